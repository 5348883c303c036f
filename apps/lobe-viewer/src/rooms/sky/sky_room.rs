//! The room: the panel, and the pictures.

use eframe::egui::{CentralPanel, ComboBox, Panel, ScrollArea, Slider, Ui};
use lobe::env::Mapping;
use lobe::prt::Transfer;
use lobe::sh::Expansion as _;

use crate::loading::sky_source::OpenedSky;
use crate::rooms::sky::edits::SkyEdits;
use crate::rooms::sky::findings::Findings;
use crate::rooms::sky::panels::Panels;
use crate::widgets::bars::bars;
use crate::widgets::history::{Can, History, Step};

/// The most lights that are looked for.
const MOST_LIGHTS: usize = 4;

/// An environment and its expansions.
pub struct SkyRoom {
    edits: SkyEdits,
    history: History<SkyEdits>,
    found: Option<Findings>,
    panels: Panels,
}

impl SkyRoom {
    /// The room as it was left.
    #[must_use]
    pub fn new(mut edits: SkyEdits) -> Self {
        edits.order = edits.order.clamp(1, Transfer::MAX_ORDER);
        edits.lights = edits.lights.min(MOST_LIGHTS);
        Self { edits, history: History::default(), found: None, panels: Panels::default() }
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
        if let Some(sky) = sky {
            self.found = Some(Findings::of(self.found.take(), &sky.map, &self.edits));
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
        ui.collapsing("As numbers", |ui| {
            for l in 0..found.light.order() {
                for (k, c) in found.light.band(l).iter().enumerate() {
                    let [r, g, b] = <[f64; 3]>::from(*c);
                    ui.monospace(format!("{l}, {:>2}: {r:9.4} {g:9.4} {b:9.4}", k as isize - l as isize));
                }
            }
        });
    }
}
