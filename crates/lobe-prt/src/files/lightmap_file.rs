//! Lightmaps of transfer as OpenEXR pictures.

use std::path::Path;

use lobe_image::{ExrAttribute, ExrLayers, ImageError};
use lobe_io::{IoError, Job, read_file, write_atomically};
use serde_json::{Value, json};

use crate::error::PrtError;
use crate::job::checkpoint::rows_at_once;
use crate::job::meter::Meter;
use crate::recipe::Recipe;
use crate::transfer::transfer::{Channels, Transfer};
use crate::transfer::transfer_rows::TransferRows;

/// The version of the attribute. Files with a higher one are refused.
const VERSION: u64 = 1;
const FORMAT: &str = "lobe-lightmap";

/// The attribute that describes the picture.
const ATTRIBUTE: &str = "lobe";

/// The channels of a layer.
const fn names(channels: Channels) -> &'static [&'static str] {
    match channels {
        Channels::Gray => &["Y"],
        Channels::Rgb => &["R", "G", "B"],
    }
}

/// The name of a channel: its layer is the number of the coefficient, of two digits, so that files list them in order.
fn channel(coefficient: usize, name: &str) -> String {
    format!("sh{coefficient:02}.{name}")
}

/// Writes the transfer of a square lightmap, row 0 at the top where v is 0, as an OpenEXR file of one part, 32-bit
/// floats.
///
/// Each coefficient `i = l (l + 1) + m` is a layer: its channels are `sh00.R`, `sh00.G`, `sh00.B` for colored transfer
/// and `sh00.Y` for gray, up to `sh63` at order 8. The attribute `lobe` is a string of JSON: format `lobe-lightmap`,
/// version 1, quantity, order, channels, recipe. Until all is written, nothing has the file's name. Memory holds all
/// numbers and the growing file.
///
/// # Errors
/// [`PrtError::Invalid`] if the receivers are no square, [`PrtError::Io`] if the system refuses,
/// [`PrtError::Cancelled`] if the job was told to stop.
pub fn write_lightmap(
    path: impl AsRef<Path>,
    transfer: &dyn TransferRows,
    recipe: &Recipe,
    job: Job<'_>,
) -> Result<(), PrtError> {
    let path = path.as_ref();
    let file = path.display().to_string();
    let receivers = transfer.receivers();
    let width = receivers.isqrt();
    if width * width != receivers {
        return Err(PrtError::invalid(
            &file,
            format!("expected transfer of a square picture, found {receivers} points"),
        ));
    }
    let about = json!({
        "format": FORMAT,
        "version": VERSION,
        "quantity": "transfer",
        "order": transfer.order(),
        "channels": transfer.channels().count(),
        "recipe": recipe,
    });
    let mut meter = Meter::new(receivers, job)?;
    let mut planes = planes(transfer, &file, &mut meter)?.into_iter();
    let mut picture = ExrLayers::new(width, width);
    for name in names(transfer.channels()) {
        for (i, plane) in planes.by_ref().take(transfer.order().pow(2)).enumerate() {
            picture.channel(channel(i, name), plane);
        }
    }
    picture.attribute(ATTRIBUTE, ExrAttribute::Text(about.to_string()));
    let bytes = picture.into_bytes().map_err(|message| PrtError::invalid(&file, message))?;
    write_atomically(path, |out| out.write_all(&bytes)).map_err(|source| IoError::io(path, source).into())
}

/// The pictures of all coefficients, channel by channel; `place` stands for them in messages.
fn planes(transfer: &dyn TransferRows, place: &str, meter: &mut Meter<'_>) -> Result<Vec<Vec<f32>>, PrtError> {
    let (receivers, row) = (transfer.receivers(), transfer.row_len());
    let mut planes: Vec<Vec<f32>> = (0..row).map(|_| Vec::with_capacity(receivers)).collect();
    let mut rows = vec![0.0; row * rows_at_once(row).min(receivers)];
    for first in (0..receivers).step_by(rows_at_once(row)) {
        meter.go_on()?;
        let rows = &mut rows[..row * rows_at_once(row).min(receivers - first)];
        let read = transfer.read_rows(first, rows);
        read.map_err(|source| IoError::io(Path::new(place), source))?;
        for (k, plane) in planes.iter_mut().enumerate() {
            plane.extend(rows[k..].iter().step_by(row));
        }
        meter.step(rows.len() / row);
    }
    Ok(planes)
}

/// Reads what [`write_lightmap`] wrote: the transfer and its recipe.
///
/// # Errors
/// [`PrtError::Io`] if the file cannot be read, [`PrtError::Unsupported`] if it is of a newer version,
/// [`PrtError::Invalid`] if it is none of ours or contradicts itself.
pub fn read_lightmap(path: impl AsRef<Path>) -> Result<(Transfer, Recipe), PrtError> {
    let path = path.as_ref();
    read_lightmap_bytes(&read_file(path)?, &path.display().to_string())
}

/// [`read_lightmap`] from the bytes of a file, whose name stands in messages.
///
/// # Errors
/// As [`read_lightmap`].
pub fn read_lightmap_bytes(bytes: &[u8], name: &str) -> Result<(Transfer, Recipe), PrtError> {
    let invalid = |message: String| PrtError::invalid(name, message);
    let layers = ExrLayers::from_bytes(bytes, name).map_err(|error| match error {
        ImageError::Invalid { place, message } => PrtError::Invalid { place, message },
        other => PrtError::invalid(name, other.to_string()),
    })?;
    let about = match layers.get_attribute(ATTRIBUTE) {
        Some(ExrAttribute::Text(text)) => serde_json::from_str(text).ok(),
        _ => None,
    };
    let about: Value = about.ok_or_else(|| invalid(format!("expected JSON as the attribute {ATTRIBUTE}")))?;
    let (order, channels) = order_and_channels(&about, name)?;
    let (width, height) = layers.size();
    if width != height {
        return Err(invalid(format!("expected a square picture, found {width} x {height} texels")));
    }
    let mut planes = Vec::new();
    for c in names(channels) {
        for i in 0..order * order {
            let wanted = channel(i, c);
            let values =
                layers.get(&wanted).ok_or_else(|| invalid(format!("expected a channel {wanted} of floats")))?;
            planes.push(values);
        }
    }
    let coefficients = (0..width * height).flat_map(|texel| planes.iter().map(move |plane| plane[texel])).collect();
    let transfer = Transfer::new(order, channels, coefficients).map_err(|error| error.within(name))?;
    Ok((transfer, Recipe::from(about["recipe"].clone()).understood(name)?))
}

fn order_and_channels(about: &Value, name: &str) -> Result<(usize, Channels), PrtError> {
    let expected = |what: &str, member: &str| {
        let message = format!("expected {what} as {member} in the attribute {ATTRIBUTE}, found {}", about[member]);
        PrtError::invalid(name, message)
    };
    if about["format"] != FORMAT {
        return Err(expected(FORMAT, "format"));
    }
    match about["version"].as_u64() {
        Some(VERSION) => {}
        Some(version) if version > VERSION => {
            let message = format!("written by a newer Lobe: expected version {VERSION}, found {version}: update Lobe");
            return Err(PrtError::Unsupported { place: name.to_owned(), message });
        }
        _ => return Err(expected("version 1", "version")),
    }
    let channels = match about["channels"].as_u64() {
        Some(1) => Channels::Gray,
        Some(3) => Channels::Rgb,
        _ => return Err(expected("1 or 3", "channels")),
    };
    match about["order"].as_u64() {
        Some(order @ 1..=8) => Ok((order as usize, channels)),
        _ => Err(expected("1 to 8", "order")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(transfer: &Transfer) -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.exr");
        write_lightmap(&path, transfer, &Recipe::default().scene("Gießerei".to_owned()), Job::default()).unwrap();
        std::fs::read(path).unwrap()
    }

    fn numbered(order: usize, channels: Channels, texels: usize) -> Transfer {
        let count = order * order * channels.count() * texels;
        Transfer::new(order, channels, (0..count).map(|i| (i as f32).sqrt() - 3.0).collect()).unwrap()
    }

    #[test]
    fn what_is_written_is_read_bit_for_bit() {
        for (order, channels, texels) in [(1, Channels::Gray, 1), (3, Channels::Rgb, 49), (8, Channels::Gray, 400)] {
            let transfer = numbered(order, channels, texels);
            let (found, recipe) = read_lightmap_bytes(&written(&transfer), "t").unwrap();
            assert!(found == transfer, "order {order}, {channels:?}");
            assert_eq!(recipe, Recipe::from(json!({"scene": "Gießerei"})), "recipe");
        }
    }

    #[test]
    fn every_coefficient_is_a_layer_in_its_place() {
        let transfer = numbered(3, Channels::Rgb, 16);
        let layers = ExrLayers::from_bytes(&written(&transfer), "t").unwrap();
        let found = layers.get("sh05.G").unwrap()[6];
        assert_eq!(found, transfer.vector(6, 1)[5], "texel 2, 1");
    }

    #[test]
    fn what_is_no_lightmap_is_refused_in_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let refused = write_lightmap(
            folder.path().join("t.exr"),
            &numbered(1, Channels::Gray, 5),
            &Recipe::default(),
            Job::default(),
        );
        assert!(
            refused.unwrap_err().to_string().ends_with("expected transfer of a square picture, found 5 points"),
            "5"
        );
        let bytes = written(&numbered(2, Channels::Gray, 9));
        let changed = |from: &str, to: &str| {
            assert_eq!(from.len(), to.len(), "the length of an attribute stands before it");
            let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
            let mut bad = bytes.clone();
            bad[at..at + from.len()].copy_from_slice(to.as_bytes());
            read_lightmap_bytes(&bad, "t").unwrap_err().to_string()
        };
        for (from, to, expected) in [
            ("\"version\":1", "\"version\":7", "t: written by a newer Lobe: expected version 1, found 7: update Lobe"),
            ("\"order\":2", "\"order\":9", "t: expected 1 to 8 as order in the attribute lobe, found 9"),
            ("\"order\":2", "\"order\":3", "t: expected a channel sh04.Y of floats"),
            ("\"channels\":1", "\"channels\":2", "t: expected 1 or 3 as channels in the attribute lobe, found 2"),
            (
                "lobe-lightmap",
                "lobe-nightmap",
                "t: expected lobe-lightmap as format in the attribute lobe, found \"lobe-nightmap\"",
            ),
            ("{\"channels", "?\"channels", "t: expected JSON as the attribute lobe"),
        ] {
            assert_eq!(changed(from, to), expected, "{from} as {to}");
        }
        for length in (0..bytes.len()).step_by(7) {
            let error = read_lightmap_bytes(&bytes[..length], "t").unwrap_err().to_string();
            assert!(error.starts_with("t: ") && !error.contains('\n'), "cut off after {length}: {error}");
        }
    }
}
