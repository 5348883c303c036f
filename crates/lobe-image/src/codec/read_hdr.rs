//! Radiance (.hdr) decoder.

use std::io::{Cursor, ErrorKind};

use image::ImageDecoder;
use image::codecs::hdr::{HdrDecoder, HdrMetadata};

use crate::ImageError;
use crate::codec::decoded::{Decoded, check_size, invalid, reserve, unsupported};
use crate::pixel::Pixel;

/// Bytes of a decoded texel: three `f32`.
const TEXEL_BYTES: usize = 12;

/// Rows of these widths may be in the new run-length encoding; then they begin with 2, 2 and the width.
const RUN_WIDTHS: std::ops::RangeInclusive<usize> = 8..=32767;

/// Decodes a Radiance picture; `name` stands for the file in messages.
pub(crate) fn decode(bytes: &[u8], name: &str, max_texels: usize) -> Result<Decoded, ImageError> {
    let mut reader = Cursor::new(bytes);
    // Not strict: the strict decoder knows the signature #?RADIANCE only, but #?RGBE is common too.
    let decoder = HdrDecoder::new_nonstrict(&mut reader).map_err(|e| explain(&e, name))?;
    let metadata = decoder.metadata();
    let (width, height) = check_size(metadata.width.into(), metadata.height.into(), max_texels, name)?;
    let header = header_len(bytes);
    let least = least_bytes(width, height);
    if ((bytes.len() - header) as u64) < least {
        let rest = bytes.len() - header;
        let message =
            format!("the file ends early: {width} x {height} texels need {least} bytes at the least, {rest} are there");
        return Err(invalid(name, message));
    }
    check_first_row(&bytes[header..], width, name)?;
    let count = width * height;
    let mut raw = reserve(count * TEXEL_BYTES, name)?;
    let mut texels = reserve(count, name)?;
    raw.resize(count * TEXEL_BYTES, 0);
    decoder.read_image(&mut raw).map_err(|e| explain(&e, name))?;

    let mut notes = Vec::new();
    let factor = radiance_factor(&metadata, name, &mut notes)?;
    note_attributes(&metadata, &mut notes);
    let (channels, _) = raw.as_chunks::<4>();
    texels.extend(channels.as_chunks::<3>().0.iter().map(|texel| {
        let [r, g, b] = texel.map(f32::from_ne_bytes);
        [r * factor[0], g * factor[1], b * factor[2]]
    }));
    Ok(Decoded { width, height, texels, notes, envmap: None })
}

/// The length of the header: everything up to the end of the line after the first empty line.
fn header_len(bytes: &[u8]) -> usize {
    let end = |from: usize, pattern: &[u8]| {
        bytes[from..]
            .windows(pattern.len())
            .position(|w| w == pattern)
            .map_or(bytes.len(), |p| from + p + pattern.len())
    };
    end(end(0, b"\n\n"), b"\n")
}

/// Refuses a picture whose first row declares another width than the header: the decoder does not check.
fn check_first_row(pixels: &[u8], width: usize, name: &str) -> Result<(), ImageError> {
    match *pixels {
        [2, 2, high, low, ..] if high < 128 && RUN_WIDTHS.contains(&width) => {
            let marked = usize::from(high) << 8 | usize::from(low);
            if marked == width {
                return Ok(());
            }
            let message =
                format!("damaged Radiance picture: {width} columns, but the first row is marked with {marked}");
            Err(invalid(name, message))
        }
        _ => Ok(()),
    }
}

/// The least number of bytes of a picture.
///
/// The densest rows are those of the old encoding: one texel of four bytes, then one repeat count for each digit of
/// `width - 1` in base 256, four bytes each.
fn least_bytes(width: usize, height: usize) -> u64 {
    let mut digits = 0;
    let mut rest = width - 1;
    while rest > 0 {
        digits += 1;
        rest /= 256;
    }
    4 * (1 + digits) * height as u64
}

/// The factor from stored values to radiance: `1 / (EXPOSURE COLORCORR)`.
fn radiance_factor(metadata: &HdrMetadata, name: &str, notes: &mut Vec<String>) -> Result<Pixel, ImageError> {
    let exposure = metadata.exposure.unwrap_or(1.0);
    let (r, g, b) = metadata.color_correction.unwrap_or((1.0, 1.0, 1.0));
    let factors = [r, g, b].map(|c| 1.0 / (exposure * c));
    if !factors.iter().all(|f| f.is_normal() && *f > 0.0) {
        let message =
            format!("EXPOSURE {exposure:?} and COLORCORR {r:?} {g:?} {b:?} must be positive numbers of ordinary size");
        return Err(invalid(name, message));
    }
    if factors != [1.0; 3] {
        notes.push(format!("EXPOSURE {exposure} and COLORCORR {r} {g} {b} of the header are divided out"));
    }
    Ok(factors)
}

/// Adds remarks on header lines that are ignored.
fn note_attributes(metadata: &HdrMetadata, notes: &mut Vec<String>) {
    for (key, value) in &metadata.custom_attributes {
        let numbers: Vec<f64> = value.split_whitespace().filter_map(|n| n.parse().ok()).collect();
        let neutral = match key.as_str() {
            // Some programs write eight zeros for "unknown".
            "PRIMARIES" => numbers.iter().all(|n| *n == 0.0),
            "GAMMA" | "PIXASPECT" => numbers == [1.0],
            _ => true,
        };
        if !neutral {
            notes.push(format!("{key}={} of the header is ignored", value.trim()));
        }
    }
}

/// Translates an error of the decoder.
fn explain(error: &image::ImageError, name: &str) -> ImageError {
    match error {
        image::ImageError::IoError(e) if e.kind() == ErrorKind::UnexpectedEof => {
            invalid(name, "the file ends early: rows of the picture are missing".into())
        }
        image::ImageError::Unsupported(e) => {
            let message = "only RGBE pictures with rows from the top and columns from the left (-Y h +X w) are read";
            unsupported(name, format!("{message}: {e}"))
        }
        other => invalid(name, format!("damaged Radiance picture: {other}")),
    }
}
