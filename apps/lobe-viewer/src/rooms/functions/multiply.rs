//! The product of two functions.

use eframe::egui::{Slider, Ui};
use lobe::sh::Expansion as _;

use crate::rooms::functions::edits::FunctionsEdits;
use crate::rooms::functions::figures::Stand;
use crate::rooms::functions::rotate::{numbers, row};

pub(crate) fn controls(ui: &mut Ui, edits: &mut FunctionsEdits) {
    edits.shape.controls(ui, "f", edits.order, edits.opened.is_some());
    edits.other.controls(ui, "g", edits.order, false);
    ui.add(Slider::new(&mut edits.between, 0.0..=180.0).text("Angle between them").suffix("°").fixed_decimals(0));
    ui.weak("The product of two functions of order n has order 2n - 1; what is kept is its first n bands.");
}

pub(crate) fn show(ui: &mut Ui, edits: &FunctionsEdits, stand: &mut Stand<'_>) {
    let (f, g) = (edits.function(), edits.other_factor());
    let kept = f.product(&g, edits.order);
    let all = f.product(&g, 2 * edits.order - 1);
    for (number, (name, f)) in [("f", &f), ("g", &g), ("f g", &kept)].into_iter().enumerate() {
        row(ui, stand, number, name, (f, None));
    }
    let (kept_energy, energy) = (kept.dot(&kept), all.dot(&all));
    let lost = if energy > 0.0 { 100.0 * (1.0 - kept_energy / energy) } else { 0.0 };
    ui.label(format!("Energy cut off with the bands above: {lost:.2} %"));
    numbers(ui, "f g", &kept);
}
