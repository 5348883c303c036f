//! A light that rings, and what ends it.

use eframe::egui::{Color32, Slider, Ui, vec2};
use lobe::sh::extrema::certified_minimum;
use lobe::sh::filter::scale_bands_in_place;
use lobe::sh::{Dir, Expansion as _, ShVec, Zonal};

use crate::rooms::functions::edits::FunctionsEdits;
use crate::rooms::functions::figures::Stand;
use crate::rooms::functions::rotate::row;
use crate::widgets::curve::{Axis, Curve, curves};

/// The part of the largest value within which a minimum is found.
const TOLERANCE: f64 = 1e-9;

pub(crate) fn controls(ui: &mut Ui, edits: &mut FunctionsEdits) {
    ui.add(
        Slider::new(&mut edits.half_angle, 1.0..=90.0).text("Half angle of the light").suffix("°").fixed_decimals(0),
    );
    edits.taming.controls(ui, edits.order);
    ui.weak("Cut off at a band, a small light swings below zero around it. Windows blur it until it no longer does; dering takes as little as it can, and less where only the irradiance must not be negative.");
}

pub(crate) fn show(ui: &mut Ui, edits: &FunctionsEdits, stand: &mut Stand<'_>) {
    let before = edits.ringing_light();
    let (mut after, factors) = (before.clone(), edits.taming.factors(&before));
    scale_bands_in_place(after.coefficients_mut(), &factors);
    row(ui, stand, 0, "the light", (&before, None));
    row(ui, stand, 1, "the light, tamed", (&after, Some(&before)));
    let received = |f: &ShVec<f64>| f.convolved(&Zonal::clamped_cosine(edits.order));
    let irradiance = [received(&before), received(&after)];
    for (name, f) in [
        ("Minimum", &before),
        ("Minimum, tamed", &after),
        ("Minimum of the irradiance", &irradiance[0]),
        ("Minimum of the irradiance, tamed", &irradiance[1]),
    ] {
        let found = certified_minimum(f.coefficients(), TOLERANCE);
        let at = found.dir.theta().to_degrees();
        ui.label(format!("{name}: {:.5}, {at:.0}° from the axis", found.lo));
    }
    let edge = edits.half_angle.to_radians();
    let of = |theta: f64| Dir::from_angles(theta, 0.0);
    let truth = |theta: f64| if theta <= edge { 1.0 } else { 0.0 };
    let (first, second) = (|theta: f64| before.eval(of(theta)), |theta: f64| after.eval(of(theta)));
    let all = [
        Curve { name: "the light itself", color: Color32::GRAY, f: &truth },
        Curve { name: "its expansion", color: Color32::from_rgb(214, 72, 56), f: &first },
        Curve { name: "tamed", color: Color32::from_rgb(50, 150, 90), f: &second },
    ];
    let size = vec2(ui.available_width().clamp(200.0, 720.0), 220.0);
    curves(ui, "Radiance by the angle from the axis", size, &Axis::angles(std::f64::consts::PI), &all);
    show_factors(ui, &factors);
}

/// The factors of the bands, as numbers and as a curve.
fn show_factors(ui: &mut Ui, factors: &[f64]) {
    let text = factors.iter().map(|w| format!("{w:.4}")).collect::<Vec<_>>().join(" ");
    ui.label(format!("Factors of the bands: {text}"));
    let last = factors.len().saturating_sub(1);
    let factor = |l: usize| factors.get(l.min(last)).copied().unwrap_or(0.0);
    let between = |l: f64| {
        let below = l.floor();
        let (low, high) = (factor(below as usize), factor(below as usize + 1));
        low + (l - below) * (high - low)
    };
    let all = [Curve { name: "w", color: Color32::from_rgb(50, 150, 90), f: &between }];
    let size = vec2(ui.available_width().clamp(200.0, 720.0), 140.0);
    curves(ui, "Factors by the band", size, &Axis::bands(factors.len()), &all);
}
