//! Encoders of HDR pictures: Radiance, OpenEXR and portable float map.

use derive_setters::Setters;
use std::path::Path;

use exr::prelude::f16;
use image::codecs::hdr::HdrEncoder;

use crate::ImageError;
use crate::codec::rgbe;
use crate::codec::write_exr;
use crate::pixel::{IntoPixel, Pixel};

/// The widest picture that the run-length encoding of Radiance can hold.
///
/// The encoder would write 32768 columns too, with a marker that no reader understands.
const MAX_HDR_WIDTH: usize = 32767;

/// The largest value of RGBE: mantissa 255/256, exponent 127.
const MAX_RGBE: f32 = 255.0 / 256.0 * 1.7014118e38;

/// Options of writing a picture.
#[derive(Clone, Debug, Default, PartialEq, Eq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct PictureWriteOptions {
    /// Store OpenEXR as 16-bit `half` instead of 32-bit `float`: half the size, three digits, at most 65504.
    pub half: bool,
}

/// The loss of writing a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PictureWriteReport {
    /// Texels with a channel outside the range of the format, which was clamped to it; NaN in `.hdr` becomes 0.
    pub clamped: usize,
}

/// Encodes rows of `width` pixels as Radiance `.hdr`, OpenEXR `.exr` (ZIP) or portable float map `.pfm`, depending on
/// the extension of the path. Nothing is written.
///
/// `.hdr` holds no negative numbers and two digits (the error of a channel is below 0.4 % of the largest channel of its
/// texel, of either sign); `.exr` and `.pfm` hold `f32` exactly.
///
/// # Errors
/// [`ImageError::Options`] for another extension, or a picture too wide for `.hdr`; [`ImageError::Io`] if the encoder
/// refuses.
///
/// # Panics
/// If `width` is 0 or does not divide the number of pixels.
pub fn encode_picture(
    path: &Path,
    width: usize,
    pixels: &[impl IntoPixel],
    options: &PictureWriteOptions,
) -> Result<(Vec<u8>, PictureWriteReport), ImageError> {
    assert!(width > 0 && pixels.len().is_multiple_of(width), "{} pixels in rows of {width}", pixels.len());
    let io = |source| ImageError::Io { place: path.display().to_string(), source };
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        "hdr" => {
            encode_hdr(width, pixels).map_err(|message| ImageError::Options(format!("{}: {message}", path.display())))
        }
        "exr" => encode_exr(width, pixels, options.half).map_err(|e| io(std::io::Error::other(e))),
        "pfm" => Ok(encode_pfm(width, pixels)),
        _ => {
            let message = format!("{}: an environment is written as .hdr, .exr or .pfm", path.display());
            Err(ImageError::Options(message))
        }
    }
}

/// The pixels with every channel clamped, and the number of pixels changed.
fn clamped(pixels: &[impl IntoPixel], low: f32, high: f32) -> (Vec<Pixel>, PictureWriteReport) {
    let mut report = PictureWriteReport::default();
    let texels = pixels.iter().map(|texel| {
        // A format with negative numbers has NaN too; refusing it is up to the reader.
        let channels = (*texel).into().map(|c| if c.is_nan() && low >= 0.0 { -1.0 } else { c });
        report.clamped += usize::from(channels.iter().any(|c| *c < low || *c > high));
        channels.map(|c| c.clamp(low, high))
    });
    (texels.collect(), report)
}

fn encode_hdr(width: usize, pixels: &[impl IntoPixel]) -> Result<(Vec<u8>, PictureWriteReport), String> {
    if width > MAX_HDR_WIDTH {
        return Err(format!("a .hdr holds at most {MAX_HDR_WIDTH} columns, not {width}; write .exr"));
    }
    let (texels, report) = clamped(pixels, 0.0, MAX_RGBE);
    // Below this the exponent would wrap around to the largest.
    let flushed = |c: f32| if c < f32::MIN_POSITIVE { 0.0 } else { c };
    let rounded: Vec<image::Rgb<f32>> = texels.iter().map(|t| image::Rgb(rgbe::rounded(*t).map(flushed))).collect();
    let mut bytes = Vec::new();
    HdrEncoder::new(&mut bytes).encode(&rounded, width, pixels.len() / width).map_err(|e| e.to_string())?;
    Ok((bytes, report))
}

fn encode_exr(
    width: usize,
    pixels: &[impl IntoPixel],
    half: bool,
) -> exr::error::Result<(Vec<u8>, PictureWriteReport)> {
    if half {
        let (texels, report) = clamped(pixels, f16::MIN.to_f32(), f16::MAX.to_f32());
        return Ok((write_exr::encode(&texels, width, true)?, report));
    }
    Ok((write_exr::encode(pixels, width, false)?, PictureWriteReport::default()))
}

/// Portable float map: a header of three lines, then little-endian `f32`, the lowest row first.
fn encode_pfm(width: usize, pixels: &[impl IntoPixel]) -> (Vec<u8>, PictureWriteReport) {
    let mut bytes = format!("PF\n{width} {}\n-1.0\n", pixels.len() / width).into_bytes();
    for row in pixels.chunks_exact(width).rev() {
        bytes.extend(row.iter().flat_map(|t| (*t).into()).flat_map(f32::to_le_bytes));
    }
    (bytes, PictureWriteReport::default())
}
