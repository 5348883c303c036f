//! A function that is turned.

use eframe::egui::{Slider, SliderClamping, Ui};
use lobe::sh::{Dir, Expansion as _, ShVec};

use crate::rooms::functions::edits::FunctionsEdits;
use crate::rooms::functions::figures::{Pair, Stand, in_rows};
use crate::widgets::bars::bars;

pub(crate) fn controls(ui: &mut Ui, edits: &mut FunctionsEdits) {
    edits.shape.controls(ui, "f", edits.order, edits.opened.is_some());
    for (angle, name) in edits.angles.iter_mut().zip(["Yaw", "Pitch", "Roll"]) {
        let slider = Slider::new(angle, -180.0..=180.0).text(name).suffix("°").fixed_decimals(0);
        // Drags turn by parts of a degree.
        ui.add(slider.clamping(SliderClamping::Edits));
    }
    ui.weak("A rotation mixes the coefficients within a band and leaves the energy of each band as it is.");
}

pub(crate) fn show(ui: &mut Ui, edits: &FunctionsEdits, stand: &mut Stand<'_>) {
    let before = edits.function();
    let after = before.rotated(&edits.rotation());
    row(ui, stand, 0, "f", (&before, None));
    row(ui, stand, 1, "f turned", (&after, Some(&before)));
    numbers(ui, "f turned", &after);
}

/// The figures of a function and the bars of its coefficients, with another function dashed in the polar plot.
pub(crate) fn row(
    ui: &mut Ui,
    stand: &mut Stand<'_>,
    number: usize,
    name: &str,
    (f, beside): (&ShVec<f64>, Option<&ShVec<f64>>),
) {
    ui.strong(name);
    in_rows(ui, |ui| {
        let key: Vec<f64> =
            f.coefficients().iter().chain(beside.iter().flat_map(|f| f.coefficients())).copied().collect();
        let of = |s: Dir| f.eval(s);
        let of_beside = |s: Dir| beside.map_or(0.0, |f| f.eval(s));
        let pair = Pair { f: &of, beside: beside.is_some().then_some(&of_beside) };
        stand.show(ui, number, (name, &format!("Balloon of {name}")), &pair, (&key, None));
        bars(ui, &format!("Coefficients of {name}"), f);
    });
}

/// The coefficients and the energy of each band as text.
pub(crate) fn numbers(ui: &mut Ui, name: &str, f: &ShVec<f64>) {
    ui.strong(format!("Numbers of {name}"));
    for (l, energy) in f.band_energies().iter().enumerate() {
        let row: Vec<String> = f.band(l).iter().map(|c| format!("{c:8.4}")).collect();
        ui.monospace(format!("band {l}: {}   energy {energy:.4}", row.join(" ")));
    }
}
