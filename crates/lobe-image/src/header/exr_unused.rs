//! Attributes and layers of OpenEXR that say something of the light and are not used, as notes.

use std::collections::BTreeSet;

use exr::meta::attribute::AttributeValue;
use exr::meta::header::Header;

use crate::header::decoded::quoted;

/// Attributes in which programs write the color space of the values.
const COLOR_SPACES: [&str; 3] = ["colorInteropID", "oiio:ColorSpace", "colorspace"];

/// Names of linear light in the primaries of Rec. 709, or of no color, in small letters: of `OpenImageIO`,
/// `OpenColorIO` and its configurations.
const USUAL: [&str; 15] = [
    "data",
    "g10_rec709",
    "lin_rec709",
    "lin_rec709_scene",
    "lin_rec709_srgb",
    "lin_srgb",
    "linear",
    "linear rec.709 (srgb)",
    "linear srgb",
    "raw",
    "scene-linear",
    "scene_linear",
    "unknown",
    "utility - linear - rec.709",
    "utility - linear - srgb",
];

/// Layers of renderers and denoisers that hold no light.
const NOT_LIGHT: [&str; 11] =
    ["albedo", "cryptomatte", "depth", "id", "motion", "normal", "position", "uv", "variance", "vector", "z"];

/// The most layers or views that a note names.
const NAMED: usize = 6;

/// Notes on what a part says besides the texels of the channels that are read.
pub(crate) fn notes(header: &Header, read: [usize; 3]) -> Vec<String> {
    let mut notes = Vec::new();
    let attributes = &header.own_attributes;
    if let Some(luminance) = attributes.white_luminance {
        notes.push(format!("whiteLuminance={luminance} of the header is not used: a value is taken as radiance"));
    }
    if attributes.adopted_neutral.is_some() {
        notes.push("adoptedNeutral of the header is not used".into());
    }
    for (key, value) in &attributes.other {
        let (key, AttributeValue::Text(value)) = (key.to_string(), value) else { continue };
        let value = quoted(&value.to_string());
        let is_usual = USUAL.contains(&value.to_ascii_lowercase().as_str());
        if COLOR_SPACES.contains(&key.as_str()) && !is_usual && !value.is_empty() {
            notes
                .push(format!("{key}={value} of the header is not used: values are taken as linear light of Rec. 709"));
        }
    }
    if let Some(views) = attributes.multi_view_names.as_ref().filter(|views| views.len() > 1) {
        let views: Vec<_> = views.iter().map(ToString::to_string).collect();
        notes.push(format!("of the views {} one is read, {}", some(&views), quoted(&views[0])));
    }
    let layers = other_layers(header, read);
    if !layers.is_empty() {
        notes.push(format!("layers that are not read: {}", some(&layers.into_iter().collect::<Vec<_>>())));
    }
    notes
}

/// The first names, and how many more there are.
fn some(names: &[String]) -> String {
    let more = if names.len() > NAMED { format!(" and {} more", names.len() - NAMED) } else { String::new() };
    names.iter().take(NAMED).map(|name| quoted(name)).collect::<Vec<_>>().join(", ") + &more
}

/// The layers of color besides the one that is read. Channels X, Y and Z without a layer are one: the color of the picture in CIE XYZ.
fn other_layers(header: &Header, read: [usize; 3]) -> BTreeSet<String> {
    let names: Vec<String> = header.channels.list.iter().map(|channel| channel.name.to_string()).collect();
    let layer_of = |name: &str| name.rsplit_once('.').map_or(String::new(), |(layer, _)| layer.to_owned());
    let own = layer_of(&names[read[0]]);
    let is_color = |name: &&String| matches!(name.rsplit('.').next(), Some("R" | "G" | "B" | "X" | "Y"));
    let is_light = |layer: &String| {
        let last = layer.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
        *layer != own && !NOT_LIGHT.iter().any(|word| last.starts_with(word))
    };
    names.iter().filter(is_color).map(|name| layer_of(name)).filter(is_light).collect()
}
