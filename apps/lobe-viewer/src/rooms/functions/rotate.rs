//! A function that is turned.

use eframe::egui::{Slider, Ui};
use lobe::sh::{Expansion as _, ShVec};

use crate::rooms::functions::edits::FunctionsEdits;
use crate::widgets::balloon::{BalloonView, Shown};
use crate::widgets::bars::bars;
use crate::widgets::orbit::Orbit;

pub(crate) fn controls(ui: &mut Ui, edits: &mut FunctionsEdits) {
    edits.shape.controls(ui, "f", edits.order);
    for (angle, name) in edits.angles.iter_mut().zip(["Yaw", "Pitch", "Roll"]) {
        ui.add(Slider::new(angle, -180.0..=180.0).text(name).suffix("°").fixed_decimals(0));
    }
    ui.weak("A rotation mixes the coefficients within a band and leaves the energy of each band as it is.");
}

pub(crate) fn show(ui: &mut Ui, edits: &FunctionsEdits, balloons: &mut [BalloonView; 3], eye: &mut Orbit) {
    let before = edits.function();
    let after = edits.rotation().rotated(&before);
    ui.horizontal_wrapped(|ui| {
        for (balloon, (name, f)) in balloons.iter_mut().zip([("f", &before), ("f turned", &after)]) {
            ui.vertical(|ui| column(ui, name, f, balloon, eye));
        }
    });
    numbers(ui, "f turned", &after);
}

/// A balloon and the bars of its coefficients.
pub(crate) fn column(ui: &mut Ui, name: &str, f: &ShVec<f64>, balloon: &mut BalloonView, eye: &mut Orbit) {
    ui.strong(name);
    let title = format!("Balloon of {name}");
    let shown = Shown { name: &title, key: f.coefficients(), f: |s| f.eval(s), extent: None };
    balloon.show(ui, 240.0, eye, &shown);
    bars(ui, &format!("Coefficients of {name}"), f);
}

/// The coefficients and the energy of each band as text.
pub(crate) fn numbers(ui: &mut Ui, name: &str, f: &ShVec<f64>) {
    ui.strong(format!("Numbers of {name}"));
    for (l, energy) in f.band_energies().iter().enumerate() {
        let row: Vec<String> = f.band(l).iter().map(|c| format!("{c:8.4}")).collect();
        ui.monospace(format!("band {l}: {}   energy {energy:.4}", row.join(" ")));
    }
}
