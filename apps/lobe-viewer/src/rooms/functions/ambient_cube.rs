//! Irradiance by an ambient cube, which wobbles while the light turns.

use std::f64::consts::TAU;

use eframe::egui::{Color32, Slider, SliderClamping, Ui, vec2};
use lobe::sh::encoding::AmbientCube;
use lobe::sh::{Dir, Expansion as _, Sh, ShL2, Zonal};

use crate::rooms::functions::edits::FunctionsEdits;
use crate::rooms::functions::figures::{Pair, Stand, in_rows};
use crate::widgets::curve::{Axis, Curve, curves};

/// A slider that sets whole degrees, and leaves what a drag has made of them.
fn degrees<'a>(slider: Slider<'a>, text: &str) -> Slider<'a> {
    slider.text(text).suffix("°").fixed_decimals(0).clamping(SliderClamping::Edits)
}

pub(crate) fn controls(ui: &mut Ui, edits: &mut FunctionsEdits) {
    ui.add(degrees(Slider::new(&mut edits.light_at, 0.0..=360.0), "Azimuth of the light"));
    ui.add(degrees(Slider::new(&mut edits.light_height, -90.0..=90.0), "Height of the light"));
    ui.weak("A surface that always faces the light receives the same from it wherever it is. Nine coefficients keep that; six faces of a cube do not.");
}

/// Irradiance under light from one direction, to order 3.
#[must_use]
pub(crate) fn irradiance(light: Dir) -> Sh<9, f64> {
    ShL2::impulse(light, 1.0).convolved(&Zonal::clamped_cosine(3))
}

pub(crate) fn show(ui: &mut Ui, edits: &FunctionsEdits, stand: &mut Stand<'_>) {
    let height = edits.light_height.to_radians();
    let light = |azimuth: f64| Dir::from_angles(std::f64::consts::FRAC_PI_2 - height, azimuth);
    let now = light(edits.light_at.to_radians());
    let f = irradiance(now);
    let cube = AmbientCube::from_irradiance_sh(&f);
    let extent = Some(f.eval(now));
    let key = [edits.light_at, edits.light_height];
    let (by_sh, by_cube) = (|s: Dir| f.eval(s), |s: Dir| cube.eval(s));
    let rows: [(&str, &str, Pair<'_>); 2] = [
        ("Nine coefficients", "Irradiance by nine coefficients", Pair { f: &by_sh, beside: None }),
        ("Ambient cube", "Irradiance by an ambient cube", Pair { f: &by_cube, beside: Some(&by_sh) }),
    ];
    for (number, (title, balloon, pair)) in rows.iter().enumerate() {
        ui.strong(*title);
        in_rows(ui, |ui| stand.show(ui, number, (title, balloon), pair, (&key, extent)));
    }
    ui.label(format!("Facing the light: {:.4} by coefficients, {:.4} by the cube", f.eval(now), cube.eval(now)));
    let by_sh = |azimuth: f64| irradiance(light(azimuth)).eval(light(azimuth));
    let by_cube = |azimuth: f64| AmbientCube::from_irradiance_sh(&irradiance(light(azimuth))).eval(light(azimuth));
    let all = [
        Curve { name: "nine coefficients", color: Color32::from_rgb(62, 120, 214), f: &by_sh },
        Curve { name: "ambient cube", color: Color32::from_rgb(214, 120, 40), f: &by_cube },
    ];
    let size = vec2(ui.available_width().clamp(200.0, 720.0), 220.0);
    curves(ui, "Irradiance facing the light, by its azimuth", size, &Axis::angles(TAU), &all);
}
