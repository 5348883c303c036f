//! Writing environment maps to files.

use std::path::Path;

use exr::prelude::f16;
use image::codecs::hdr::HdrEncoder;
use lobe_io::write_atomically;
use lobe_sh::Rgb;

use crate::codec::rgbe;
use crate::codec::write_exr;
use crate::{EnvError, EnvMap};

/// The widest picture that the run-length encoding of Radiance can hold.
///
/// The encoder would write 32768 columns too, with a marker that no reader understands.
const MAX_HDR_WIDTH: usize = 32767;

/// The largest value of RGBE: mantissa 255/256, exponent 127.
const MAX_RGBE: f32 = 255.0 / 256.0 * 1.7014118e38;

/// How to write an environment map.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// Store OpenEXR as 16-bit `half` instead of 32-bit `float`: half the size, three digits, at most 65504.
    pub half: bool,
}

/// What could not be stored as it was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteReport {
    /// Texels with a channel that the format cannot hold and that was moved to the nearest value that it can; NaN in
    /// `.hdr` becomes 0.
    pub clamped: usize,
}

/// Writes a map as Radiance `.hdr`, OpenEXR `.exr` (ZIP) or portable float map `.pfm`, as the extension says.
///
/// The file is written under a temporary name in the same folder and then renamed: nothing half-written ever has the
/// final name. `.hdr` holds no negative numbers and two digits (the error of a channel is below 0.4 % of the
/// largest channel of its texel, of either sign); `.exr` and `.pfm` hold `f32` exactly.
///
/// # Errors
/// [`EnvError::Options`] for another extension, or a map too wide for `.hdr`; [`EnvError::Io`] if the file cannot be
/// written.
pub fn write_env(path: impl AsRef<Path>, map: &EnvMap, options: &WriteOptions) -> Result<WriteReport, EnvError> {
    let path = path.as_ref();
    let (bytes, report) = encode(path, map, options)?;
    let io = |source| EnvError::Io { file: path.display().to_string(), source };
    write_atomically(path, |file| file.write_all(&bytes)).map_err(io)?;
    Ok(report)
}

/// The bytes of the file that [`write_env`] writes.
pub(crate) fn encode(path: &Path, map: &EnvMap, options: &WriteOptions) -> Result<(Vec<u8>, WriteReport), EnvError> {
    let io = |source| EnvError::Io { file: path.display().to_string(), source };
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        "hdr" => encode_hdr(map).map_err(|message| EnvError::Options(format!("{}: {message}", path.display()))),
        "exr" => encode_exr(map, options.half).map_err(|e| io(std::io::Error::other(e))),
        "pfm" => Ok(encode_pfm(map)),
        _ => {
            let message = format!("{}: an environment is written as .hdr, .exr or .pfm", path.display());
            Err(EnvError::Options(message))
        }
    }
}

/// The texels with every channel clamped, and how many were changed by it.
fn clamped(map: &EnvMap, low: f32, high: f32) -> (Vec<Rgb<f32>>, WriteReport) {
    let mut report = WriteReport::default();
    let texels = map.texels().iter().map(|texel| {
        // A format with negative numbers has NaN too; there it is for the reader to refuse.
        let channels = texel.to_array().map(|c| if c.is_nan() && low >= 0.0 { -1.0 } else { c });
        report.clamped += usize::from(channels.iter().any(|c| *c < low || *c > high));
        Rgb::from(channels.map(|c| c.clamp(low, high)))
    });
    (texels.collect(), report)
}

fn encode_hdr(map: &EnvMap) -> Result<(Vec<u8>, WriteReport), String> {
    if map.width() > MAX_HDR_WIDTH {
        return Err(format!("a .hdr holds at most {MAX_HDR_WIDTH} columns, not {}; write .exr", map.width()));
    }
    let (texels, report) = clamped(map, 0.0, MAX_RGBE);
    // Below this the exponent would wrap around to the largest.
    let flushed = |c: f32| if c < f32::MIN_POSITIVE { 0.0 } else { c };
    let pixels: Vec<image::Rgb<f32>> =
        texels.iter().map(|t| image::Rgb(rgbe::rounded(*t).to_array().map(flushed))).collect();
    let mut bytes = Vec::new();
    HdrEncoder::new(&mut bytes).encode(&pixels, map.width(), map.height()).map_err(|e| e.to_string())?;
    Ok((bytes, report))
}

fn encode_exr(map: &EnvMap, half: bool) -> exr::error::Result<(Vec<u8>, WriteReport)> {
    if half {
        let (texels, report) = clamped(map, f16::MIN.to_f32(), f16::MAX.to_f32());
        return Ok((write_exr::encode(&texels, map.width(), true)?, report));
    }
    Ok((write_exr::encode(map.texels(), map.width(), false)?, WriteReport::default()))
}

/// Portable float map: a header of three lines, then little-endian `f32`, the lowest row first.
fn encode_pfm(map: &EnvMap) -> (Vec<u8>, WriteReport) {
    let mut bytes = format!("PF\n{} {}\n-1.0\n", map.width(), map.height()).into_bytes();
    for y in (0..map.height()).rev() {
        bytes.extend(map.row(y).iter().flat_map(|t| t.to_array()).flat_map(f32::to_le_bytes));
    }
    (bytes, WriteReport::default())
}
