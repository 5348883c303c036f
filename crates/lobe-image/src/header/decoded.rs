//! Decoder results, and size limits that are checked before memory is allocated.

use crate::error::{ImageError, ReadOption};
use crate::header::xmp::Panorama;
use crate::picture::primaries::Primaries;
use crate::pixel::Pixel;

/// The most characters of a message: decoders may repeat what a file contains.
const MAX_MESSAGE: usize = 320;

/// The most characters of what a file says within a remark: eight numbers with all their digits.
const MAX_QUOTED: usize = 160;

/// The most remarks on a picture: every kind that there is, at once.
const MOST_NOTES: usize = 32;

/// The values of the attribute `envmap` of OpenEXR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum EnvmapAttribute {
    /// Longitude across, latitude down.
    LatLong,
    /// Six faces one above another.
    Cube,
}

/// What a decoder knows of a picture before its texels.
pub(crate) struct PictureHead {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) notes: Vec<String>,
    pub(crate) envmap: Option<EnvmapAttribute>,
    pub(crate) mapping: Option<String>,
    pub(crate) panorama: Panorama,
    /// The primaries that the file declares, after their name in messages.
    pub(crate) primaries: Option<(&'static str, Primaries)>,
    /// What the file says of its primaries that cannot be understood, for messages: "X of the header".
    pub(crate) unclear_primaries: Option<String>,
}

impl PictureHead {
    /// A picture without remarks.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let (notes, panorama) = (Vec::new(), Panorama::new());
        let (envmap, mapping, primaries, unclear_primaries) = (None, None, None, None);
        Self { width, height, notes, envmap, mapping, panorama, primaries, unclear_primaries }
    }
}

/// The result of a decoder.
pub(crate) struct Decoded {
    pub(crate) head: PictureHead,
    pub(crate) texels: Vec<Pixel>,
}

/// Some rows of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct RowStrip {
    /// The first of the rows, from the top.
    pub first_row: usize,
    /// Their texels, row by row.
    pub texels: Vec<Pixel>,
}

/// Refuses a picture larger than the caller allows, before memory is allocated.
pub(crate) fn check_size(width: u64, height: u64, max_texels: usize, name: &str) -> Result<(usize, usize), ImageError> {
    if width == 0 || height == 0 {
        return Err(invalid(name, format!("the picture has no texels: it is {width} x {height}")));
    }
    if width.checked_mul(height).is_none_or(|texels| texels > max_texels as u64) {
        let message = format!("the picture is {width} x {height}, more than the limit of {max_texels} texels");
        return Err(ImageError::Refused { place: name.into(), message, option: ReadOption::MaxTexels });
    }
    Ok((width as usize, height as usize))
}

/// An empty vector with room for `count` items, or an error where the system has no memory for them.
pub(crate) fn reserve<T>(count: usize, name: &str) -> Result<Vec<T>, ImageError> {
    let mut items = Vec::new();
    items.try_reserve_exact(count).map_err(|_| {
        let mib = (count.saturating_mul(size_of::<T>())) >> 20;
        ImageError::Io {
            place: name.into(),
            source: std::io::Error::new(std::io::ErrorKind::OutOfMemory, format!("no memory for {mib} MiB of texels")),
        }
    })?;
    Ok(items)
}

pub(crate) fn io(name: &str, source: std::io::Error) -> ImageError {
    ImageError::Io { place: name.into(), source }
}

pub(crate) fn invalid(name: &str, message: String) -> ImageError {
    ImageError::Invalid { place: name.into(), message: one_line(message) }
}

pub(crate) fn unsupported(name: &str, message: String) -> ImageError {
    ImageError::Unsupported { place: name.into(), message: one_line(message) }
}

/// Remarks in lines of bounded length, and not more of them than anyone reads: files may say a thing a thousand times.
pub(crate) fn bounded(mut notes: Vec<String>) -> Vec<String> {
    let more = notes.len().saturating_sub(MOST_NOTES);
    notes.truncate(MOST_NOTES);
    let mut notes: Vec<String> = notes.into_iter().map(one_line).collect();
    if more > 0 {
        notes.push(format!("{more} more remarks are left out"));
    }
    notes
}

/// A message in one line of bounded length.
fn one_line(message: String) -> String {
    if message.len() <= MAX_MESSAGE && lobe_io::one_line(&message) == message {
        return message;
    }
    shortened(&message, MAX_MESSAGE)
}

/// What a file says, within a remark.
pub(crate) fn quoted(text: &str) -> String {
    shortened(text, MAX_QUOTED)
}

/// The first characters of a text, in one line.
fn shortened(text: &str, most: usize) -> String {
    let mut line = lobe_io::one_line(&text.trim_end().chars().take(most).collect::<String>());
    if text.chars().nth(most).is_some() {
        line.push_str("...");
    }
    line
}
