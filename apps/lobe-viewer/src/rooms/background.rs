//! The background of a room: its control, and its text in what the window keeps.

use eframe::egui::{ComboBox, Ui};
use lobe::render::Background;
use lobe::sh::Rgb;
use serde::{Deserialize as _, Deserializer, Serializer};

/// What is behind the scene, by the words of the command.
pub(crate) fn control(ui: &mut Ui, chosen: &mut Background) {
    const GRAY: Rgb<f64> = Rgb { r: 0.2, g: 0.2, b: 0.2 };
    let color = if let Background::Color(color) = *chosen { color } else { GRAY };
    let choices = [Background::Env, Background::Light, Background::None, Background::Color(color)];
    let titles = ["env", "light", "none", "color"];
    let number = choices.iter().position(|choice| choice == chosen).unwrap_or(0);
    ui.horizontal(|ui| {
        ComboBox::from_label("Background").selected_text(titles[number]).show_ui(ui, |ui| {
            for (choice, title) in choices.into_iter().zip(titles) {
                ui.selectable_value(chosen, choice, title);
            }
        });
        if let Background::Color(color) = chosen {
            let mut channels = color.to_array().map(|c| c as f32);
            if ui.color_edit_button_rgb(&mut channels).changed() {
                *color = Rgb::from(channels.map(f64::from));
            }
        }
    });
}

pub(crate) fn serialize<S: Serializer>(background: &Background, to: S) -> Result<S::Ok, S::Error> {
    to.collect_str(background)
}

/// A text that is not known is the background without a choice.
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Background, D::Error> {
    Ok(String::deserialize(from)?.parse().unwrap_or_default())
}
