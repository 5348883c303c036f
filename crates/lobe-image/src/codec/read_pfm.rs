//! Portable float map decoder.

use crate::ImageError;
use crate::codec::decoded::{Decoded, check_size, invalid, reserve};

/// The longest header: three numbers and white space.
const MAX_HEADER: usize = 256;

/// Decodes a portable float map, `PF` in color or `Pf` in gray; `name` stands for the file in messages.
///
/// Three words follow the signature, each after white space: columns, rows, and a scale, whose sign gives the byte
/// order (negative: little-endian) and whose magnitude is a factor. One byte of white space ends the header. The
/// bottom row comes first.
pub(crate) fn decode(bytes: &[u8], name: &str, max_texels: usize) -> Result<Decoded, ImageError> {
    let header = Header::parse(bytes, name)?;
    let (width, height) = check_size(header.width, header.height, max_texels, name)?;
    let channels = if bytes.starts_with(b"PF") { 3 } else { 1 };
    let data = &bytes[header.length..];
    // The size passed the check of the limit, which fits a usize; so does four times three times it in a u64.
    let needed = 4 * channels as u64 * width as u64 * height as u64;
    if (data.len() as u64) < needed {
        let message =
            format!("the file ends early: {width} x {height} texels need {needed} bytes, {} are there", data.len());
        return Err(invalid(name, message));
    }
    let mut notes = Vec::new();
    let factor = header.scale.abs();
    if factor != 1.0 {
        notes.push(format!("the values are multiplied with the scale {factor} of the header"));
    }
    if data.len() as u64 > needed {
        notes.push(format!("{} bytes after the picture are ignored", data.len() as u64 - needed));
    }
    let order = if header.scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let mut texels = reserve(width * height, name)?;
    for row in data[..needed as usize].chunks_exact(4 * channels * width).rev() {
        let values = row.as_chunks::<4>().0;
        texels.extend(values.chunks_exact(channels).map(|texel| {
            let value = |c: usize| order(texel[c % channels]);
            [value(0) * factor, value(1) * factor, value(2) * factor]
        }));
    }
    Ok(Decoded { notes, ..Decoded::new(width, height, texels) })
}

struct Header {
    width: u64,
    height: u64,
    scale: f32,
    /// Bytes of the header with the white space that ends it.
    length: usize,
}

impl Header {
    fn parse(bytes: &[u8], name: &str) -> Result<Self, ImageError> {
        let mut position = 2;
        let mut word = || {
            let start = &bytes[position.min(bytes.len())..bytes.len().min(MAX_HEADER)];
            let skip = start.iter().take_while(|b| b.is_ascii_whitespace()).count();
            let length = start[skip..].iter().take_while(|b| !b.is_ascii_whitespace()).count();
            position += skip + length;
            let word = String::from_utf8_lossy(&start[skip..skip + length]).into_owned();
            (word, position)
        };
        let ((width, _), (height, _), (scale, end)) = (word(), word(), word());
        let bad = |what: &str, found: &str| {
            let found: String = found.chars().take(24).collect();
            invalid(name, format!("damaged portable float map: {what} expected in the header, found {found:?}"))
        };
        let number = |word: &str, what| word.parse().map_err(|_| bad(what, word));
        let (columns, rows) = (number(&width, "the number of columns")?, number(&height, "the number of rows")?);
        let factor: f32 = scale.parse().map_err(|_| bad("the scale", &scale))?;
        if !factor.is_normal() {
            return Err(bad("a scale that is neither 0 nor infinite", &scale));
        }
        match bytes.get(end) {
            Some(b) if b.is_ascii_whitespace() => {
                Ok(Self { width: columns, height: rows, scale: factor, length: end + 1 })
            }
            _ => Err(invalid(name, "the file ends early: there is nothing after the header".into())),
        }
    }
}
