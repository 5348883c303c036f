//! The list of lamps.

use eframe::egui::{Slider, Ui};

use crate::rooms::scene::edits::{MOST_LAMPS, SceneLamp};
use crate::widgets::named::name_fully;

/// A slider in whole degrees.
fn degrees(slider: Slider<'_>) -> Slider<'_> {
    slider.suffix("°").fixed_decimals(0)
}

/// Lamps to add, change and remove.
pub(crate) fn lamps(ui: &mut Ui, lamps: &mut Vec<SceneLamp>) {
    let mut removed = None;
    for (number, lamp) in lamps.iter_mut().enumerate() {
        ui.push_id(number, |ui| {
            let name = format!("Lamp {}", number + 1);
            ui.horizontal(|ui| {
                ui.checkbox(&mut lamp.is_on, &name);
                let color = ui.color_edit_button_rgb(&mut lamp.color).on_hover_text("Color of the lamp");
                name_fully(&color, &format!("Color of {}", name.to_lowercase()));
                if ui.button(format!("Remove {}", name.to_lowercase())).clicked() {
                    removed = Some(number);
                }
            });
            ui.add_enabled_ui(lamp.is_on, |ui| {
                let mut add = |slider: Slider<'_>, what: &str| {
                    let response = ui.add(slider.text(what));
                    name_fully(&response, &format!("{name}: {what}"));
                };
                add(degrees(Slider::new(&mut lamp.azimuth, -180.0..=180.0)), "Azimuth");
                add(degrees(Slider::new(&mut lamp.height, -90.0..=90.0)), "Height");
                add(degrees(Slider::new(&mut lamp.half_angle, 1.0..=90.0)), "Half angle");
                add(Slider::new(&mut lamp.strength, 0.0..=20.0).logarithmic(true), "Strength");
            });
        });
    }
    if let Some(number) = removed {
        lamps.remove(number);
    }
    ui.horizontal(|ui| {
        let has_room = lamps.len() < MOST_LAMPS;
        if ui.add_enabled(has_room, eframe::egui::Button::new("Add a sun")).clicked() {
            lamps.push(SceneLamp { half_angle: 1.0, strength: 1.0, ..SceneLamp::default() });
        }
        if ui.add_enabled(has_room, eframe::egui::Button::new("Add a lamp")).clicked() {
            let azimuth = 50.0 * lamps.len() as f64 - 120.0;
            let color = if lamps.len().is_multiple_of(2) { [0.35, 0.55, 1.0] } else { [1.0, 0.5, 0.25] };
            lamps.push(SceneLamp { azimuth, height: 15.0, half_angle: 15.0, color, ..SceneLamp::default() });
        }
    });
}
