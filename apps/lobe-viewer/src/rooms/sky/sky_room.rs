//! The room: the panel, and the pictures.

use std::f64::consts::TAU;
use std::sync::Arc;
use std::time::Duration;

use eframe::egui::{Button, CentralPanel, ComboBox, Context, Panel, ScrollArea, Slider, Ui};
use lobe::env::Mapping;
use lobe::prt::Transfer;
use lobe::sh::{Dir, Rotation};

use crate::loading::sky_source::OpenedSky;
use crate::rooms::sky::edits::{MOST_LIGHTS, SkyEdits};
use crate::rooms::sky::findings::Findings;
use crate::rooms::sky::panels::Panels;
use crate::widgets::bars::bars;
use crate::widgets::coefficient_table::CoefficientTable;
use crate::widgets::history::{Can, History, Step};

/// Steps of a turn of the sky that changes every second: 15 degrees each.
const STEPS: f64 = 24.0;

/// An environment and its expansions.
pub struct SkyRoom {
    edits: SkyEdits,
    history: History<SkyEdits>,
    found: Option<Findings>,
    panels: Panels,
    table: CoefficientTable,
    /// Since when the sky turns by a step each second, in seconds of the window.
    looping: Option<f64>,
}

impl SkyRoom {
    /// The room as it was left.
    #[must_use]
    pub fn new(mut edits: SkyEdits) -> Self {
        edits.check();
        let (history, panels, table) = Default::default();
        Self { edits, history, found: None, panels, table, looping: None }
    }

    /// What a user changed.
    #[must_use]
    pub fn edits(&self) -> &SkyEdits {
        &self.edits
    }

    /// Takes the last change back, or makes it again.
    pub fn step(&mut self, step: Step) {
        self.history.step(step, &mut self.edits);
    }

    pub(crate) fn can(&self) -> Can {
        self.history.can(&self.edits)
    }

    /// Shows the room on an environment.
    pub fn ui(&mut self, ui: &mut Ui, sky: Option<&OpenedSky>) {
        self.history.watch(ui.ctx(), &self.edits);
        let turn = Rotation::from_axis_angle(Dir::Z, self.turn(ui.ctx()));
        if let Some(sky) = sky {
            // What was typed belongs to the sky that was there.
            if self.found.as_ref().is_some_and(|found| !Arc::ptr_eq(found.map(), &sky.map)) {
                self.edits.own.clear();
            }
            self.found = Some(Findings::of(self.found.take(), sky, &self.edits, turn));
        }
        Panel::left("sky controls").default_size(320.0).size_range(240.0..=480.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.panel(ui, sky));
        });
        CentralPanel::default_margins().show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| match &self.found {
                Some(found) => self.panels.show(ui, found, &self.edits),
                None => {
                    ui.label("Opening the sky");
                }
            });
        });
    }

    /// The turn of the sky in radians: a step for each second that has passed, 0 at rest.
    fn turn(&self, ctx: &Context) -> f64 {
        let Some(since) = self.looping else { return 0.0 };
        let passed = (ctx.input(|input| input.time) - since).max(0.0);
        ctx.request_repaint_after(Duration::from_secs_f64(1.0 - passed.fract()));
        TAU * (passed.floor() % STEPS) / STEPS
    }

    fn panel(&mut self, ui: &mut Ui, sky: Option<&OpenedSky>) {
        ui.spacing_mut().slider_width = 120.0;
        let edits = &mut self.edits;
        ui.strong(sky.map_or("No sky", |sky| &sky.name));
        ui.weak("It is chosen in the room of scenes, or dropped on the window.");
        ui.add(Slider::new(&mut edits.order, 1..=Transfer::MAX_ORDER).text("Order"));
        edits.taming.controls(ui, edits.order);
        ui.add(Slider::new(&mut edits.lights, 0..=MOST_LIGHTS).text("Lights"));
        ui.add(Slider::new(&mut edits.exposure, -8.0..=8.0).text("Exposure").suffix(" stops").fixed_decimals(1));
        ComboBox::from_label("Mapping").selected_text(edits.mapping.as_str()).show_ui(ui, |ui| {
            for mapping in Mapping::ALL {
                ui.selectable_value(&mut edits.mapping, mapping.name().to_owned(), mapping.name());
            }
        });
        ui.separator();
        let Some(found) = &self.found else { return };
        ui.label(format!("RMS error: {:.2} times the mean", found.error));
        ui.label(format!("Minimum of the luminance: {:.4} (blue cross)", found.minimum.lo));
        if let Some(fit) = &found.lights {
            for (number, light) in fit.lights.iter().enumerate() {
                let [r, g, b] = <[f64; 3]>::from(light.intensity);
                let (azimuth, height) = (light.dir.phi().to_degrees(), 90.0 - light.dir.theta().to_degrees());
                let number = number + 1;
                ui.label(format!("Light {number}: azimuth {azimuth:.0}°, height {height:.0}°, {r:.2} {g:.2} {b:.2}"));
            }
            let [r, g, b] = <[f64; 3]>::from(fit.ambient);
            ui.label(format!("Ambient: {r:.2} {g:.2} {b:.2}"));
        }
        ui.separator();
        ui.strong("Coefficients of the luminance");
        bars(ui, "Coefficients of the luminance", &found.luminance);
        let mut is_looping = self.looping.is_some();
        let hint = "The sky turns by 15 degrees each second; its coefficients change, the energy of each band does not";
        if ui.checkbox(&mut is_looping, "Change every second").on_hover_text(hint).changed() {
            self.looping = is_looping.then(|| ui.input(|input| input.time));
        }
        ui.strong("Coefficients, red, green and blue");
        ui.weak(if is_looping { "They can be typed while they are at rest." } else { "Type into a cell, then Enter." });
        if let Some((number, value)) = self.table.show(ui, &found.light, !is_looping) {
            self.edits.replace(number, value);
        }
        let count = self.edits.own.len();
        if ui.add_enabled(count > 0, Button::new("Those of the sky again")).clicked() {
            self.edits.own.clear();
        }
    }
}
