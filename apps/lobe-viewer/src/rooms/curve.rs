//! The tone curve of a room: its control, and its name in what the window keeps.

use eframe::egui::{ComboBox, Ui};
use lobe::image::Curve;
use serde::{Deserialize as _, Deserializer, Serializer};

/// The curve that shows light, by the names of the command.
pub(crate) fn control(ui: &mut Ui, chosen: &mut Curve) {
    ComboBox::from_label("Tone").selected_text(chosen.name()).show_ui(ui, |ui| {
        for (curve, (name, description)) in Curve::ALL.into_iter().zip(Curve::NAMES) {
            ui.selectable_value(chosen, curve, name).on_hover_text(description);
        }
    });
}

pub(crate) fn serialize<S: Serializer>(curve: &Curve, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(curve.name())
}

/// A name that is not known is the curve without a choice.
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Curve, D::Error> {
    Ok(Curve::from_name(&String::deserialize(from)?).unwrap_or_default())
}
