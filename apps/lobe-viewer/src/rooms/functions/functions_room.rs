//! The room: the panel of the study, and what it shows.

use eframe::egui::{CentralPanel, Panel, ScrollArea, Slider, Ui};

use crate::rooms::functions::edits::{FunctionsEdits, MAX_ORDER, Study};
use crate::rooms::functions::{ambient_cube, multiply, ringing, rotate};
use crate::widgets::balloon::BalloonView;
use crate::widgets::history::{Can, History, Step};
use crate::widgets::orbit::Orbit;

/// Functions on the sphere.
pub struct FunctionsRoom {
    edits: FunctionsEdits,
    history: History<FunctionsEdits>,
    eye: Orbit,
    balloons: [BalloonView; 3],
}

impl FunctionsRoom {
    /// The room as it was left.
    #[must_use]
    pub fn new(mut edits: FunctionsEdits) -> Self {
        edits.check();
        let eye = Orbit { azimuth: 0.6, height: 0.45, ..Orbit::default() };
        Self { edits, history: History::default(), eye, balloons: Default::default() }
    }

    /// What a user changed.
    #[must_use]
    pub fn edits(&self) -> &FunctionsEdits {
        &self.edits
    }

    /// Takes the last change back, or makes it again.
    pub fn step(&mut self, step: Step) {
        self.history.step(step, &mut self.edits);
    }

    pub(crate) fn can(&self) -> Can {
        self.history.can(&self.edits)
    }

    /// Shows the room.
    pub fn ui(&mut self, ui: &mut Ui) {
        self.history.watch(ui.ctx(), &self.edits);
        Panel::left("function controls").default_size(300.0).size_range(220.0..=480.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.panel(ui));
        });
        CentralPanel::default_margins().show(ui, |ui| {
            ScrollArea::both().auto_shrink(false).show(ui, |ui| self.study(ui));
        });
    }

    fn panel(&mut self, ui: &mut Ui) {
        ui.spacing_mut().slider_width = 120.0;
        for study in Study::ALL {
            ui.radio_value(&mut self.edits.study, study, study.title());
        }
        ui.separator();
        if self.edits.study != Study::AmbientCube {
            ui.add(Slider::new(&mut self.edits.order, 1..=MAX_ORDER).text("Order"));
        }
        match self.edits.study {
            Study::Rotate => rotate::controls(ui, &mut self.edits),
            Study::Product => multiply::controls(ui, &mut self.edits),
            Study::Ringing => ringing::controls(ui, &mut self.edits),
            Study::AmbientCube => ambient_cube::controls(ui, &mut self.edits),
        }
        ui.separator();
        ui.weak("Balloons: r = |f(s)|, red where f is positive, blue where it is negative. Drag one to turn them all.");
    }

    fn study(&mut self, ui: &mut Ui) {
        let Self { edits, eye, balloons, .. } = self;
        match edits.study {
            Study::Rotate => rotate::show(ui, edits, balloons, eye),
            Study::Product => multiply::show(ui, edits, balloons, eye),
            Study::Ringing => ringing::show(ui, edits, balloons, eye),
            Study::AmbientCube => ambient_cube::show(ui, edits, balloons, eye),
        }
    }
}
