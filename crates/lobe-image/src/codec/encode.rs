//! Picture writers: the extension of the file decides on the format.

use std::path::Path;

use derive_setters::Setters;
use half::f16;
use lobe_io::write_atomically;

use crate::codec::file_format::FileFormat;
use crate::codec::{rgbe, write_exr};
use crate::error::ImageError;
use crate::picture::picture::Picture;
use crate::picture::png::MAPPING_KEY;
use crate::pixel::{IntoPixel, Pixel};

/// The largest value of RGBE: mantissa 255/256, exponent 127.
const MAX_RGBE: f32 = 255.0 / 256.0 * 1.7014118e38;

/// Options of writing a picture.
#[derive(Clone, Debug, Default, PartialEq, Eq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct PictureWriteOptions {
    /// Store OpenEXR as 16-bit `half` instead of 32-bit `float`: half the size, three digits, at most 65504.
    pub half: bool,
    /// The name of a mapping of directions that the file keeps, so that a reader finds it again
    /// ([`PictureReadReport::mapping`](crate::PictureReadReport)); `.pfm` has no room for it.
    #[setters(into)]
    pub mapping: Option<String>,
}

/// The loss of writing a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct PictureWriteReport {
    /// Texels with a channel outside the range of the format, which was clamped to it; NaN in `.hdr` becomes 0.
    pub clamped: usize,
    /// The share of the light that clamping took from channels which are too bright for the format, 0 to 1: of all
    /// pixels alike, or of all directions where a map is written. Of a texture it is that of its largest level.
    pub lost: f64,
}

/// Writes a picture as Radiance `.hdr`, OpenEXR `.exr` (ZIP) or portable float map `.pfm`, depending on the extension; see
/// [`encode_picture`]. No partial file ever has the final name.
///
/// OpenEXR keeps the [alpha](Picture::alpha) of a picture as channel `A`, beside colors that are associated with it, as
/// that format defines them. The other formats have none.
///
/// ```
/// use lobe_image::{Picture, PictureReadOptions, PictureWriteOptions, read_picture, write_picture};
///
/// let path = std::env::temp_dir().join(format!("lobe-write-picture-{}.exr", std::process::id()));
/// let picture = Picture::from_fn(8, 4, |x, y| [0.1 * x as f32, 0.2 * y as f32, 1.0]);
/// write_picture(&path, &picture, &PictureWriteOptions::default())?;
/// assert_eq!(read_picture(&path, &PictureReadOptions::default())?.0, picture);
/// # std::fs::remove_file(path).ok();
/// # Ok::<(), lobe_image::ImageError>(())
/// ```
///
/// # Errors
/// Those of [`encode_picture`], and [`ImageError::Io`] if the file cannot be written.
pub fn write_picture(
    path: impl AsRef<Path>,
    picture: &Picture,
    options: &PictureWriteOptions,
) -> Result<PictureWriteReport, ImageError> {
    let pixels = (picture.pixels(), picture.alpha());
    write_bytes(path.as_ref(), encode(path.as_ref(), picture.width(), pixels, options)?)
}

/// Writes rows of `width` pixels as [`write_picture`] writes a picture.
///
/// # Errors
/// Those of [`write_picture`].
///
/// # Panics
/// If `width` is 0 or does not divide the number of pixels.
pub fn write_pixels(
    path: impl AsRef<Path>,
    width: usize,
    pixels: &[impl IntoPixel],
    options: &PictureWriteOptions,
) -> Result<PictureWriteReport, ImageError> {
    let path = path.as_ref();
    write_bytes(path, encode_picture(path, width, pixels, options)?)
}

fn write_bytes(path: &Path, (bytes, report): (Vec<u8>, PictureWriteReport)) -> Result<PictureWriteReport, ImageError> {
    let io = |source| ImageError::Io { place: path.display().to_string(), source };
    write_atomically(path, |file| file.write_all(&bytes)).map_err(io)?;
    Ok(report)
}

/// Encodes rows of `width` pixels as Radiance `.hdr`, OpenEXR `.exr` (ZIP) or portable float map `.pfm`, depending on
/// the extension of the path. Nothing is written.
///
/// `.hdr` holds no negative numbers and two digits (the error of a channel is below 0.4 % of the largest channel of its
/// texel, of either sign); `.exr` and `.pfm` hold `f32` exactly.
///
/// # Errors
/// [`ImageError::Options`] for another extension, a picture without pixels, or one too large for the format.
///
/// # Panics
/// If `width` is 0 while there are pixels, or does not divide their number.
pub fn encode_picture(
    path: &Path,
    width: usize,
    pixels: &[impl IntoPixel],
    options: &PictureWriteOptions,
) -> Result<(Vec<u8>, PictureWriteReport), ImageError> {
    encode(path, width, (pixels, None), options)
}

fn encode(
    path: &Path,
    width: usize,
    (pixels, alpha): (&[impl IntoPixel], Option<&[f32]>),
    options: &PictureWriteOptions,
) -> Result<(Vec<u8>, PictureWriteReport), ImageError> {
    let wrong = |message: String| ImageError::Options(format!("{}: {message}", path.display()));
    if pixels.is_empty() {
        return Err(wrong("a picture without pixels cannot be written".to_owned()));
    }
    assert!(width > 0 && pixels.len().is_multiple_of(width), "{} pixels in rows of {width}", pixels.len());
    let is_text = |mapping: &str| mapping.chars().all(|c| !c.is_control() && c <= '\u{ff}');
    if !options.mapping.as_deref().is_none_or(is_text) {
        return Err(wrong("the name of a mapping is one line of Latin-1 characters".to_owned()));
    }
    match FileFormat::of_name(path) {
        Some(FileFormat::Radiance) => encode_hdr(width, pixels, options.mapping.as_deref()).map_err(wrong),
        Some(FileFormat::OpenExr) => {
            encode_exr(width, (pixels, alpha), options).map_err(|error| wrong(error.to_string()))
        }
        Some(FileFormat::Pfm) => Ok(encode_pfm(width, pixels)),
        _ => Err(wrong(format!("a picture is written as {}", FileFormat::names(FileFormat::is_written)))),
    }
}

/// The share of the light of pixels that their channels have above `most`.
pub(crate) fn share_beyond(pixels: &[impl IntoPixel], most: f32) -> f64 {
    let (mut all, mut beyond) = (0.0, 0.0);
    for channel in
        pixels.iter().flat_map(|pixel| (*pixel).into()).filter(|channel| *channel > 0.0 && channel.is_finite())
    {
        all += f64::from(channel);
        beyond += f64::from(channel - channel.min(most));
    }
    if beyond > 0.0 { beyond / all } else { 0.0 }
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
    let texels = texels.collect();
    report.lost = share_beyond(pixels, high);
    (texels, report)
}

fn encode_hdr(
    width: usize,
    pixels: &[impl IntoPixel],
    mapping: Option<&str>,
) -> Result<(Vec<u8>, PictureWriteReport), String> {
    // A wider picture would have to be flat, and readers take the beginning of a flat row for a mark.
    if width > rgbe::MAX_WIDTH {
        return Err(format!("a .hdr holds at most {} columns, not {width}; write .exr", rgbe::MAX_WIDTH));
    }
    let (texels, report) = clamped(pixels, 0.0, MAX_RGBE);
    let mapping = mapping.map_or(String::new(), |mapping| format!("{MAPPING_KEY}={mapping}\n"));
    let height = texels.len() / width;
    let header = format!("#?RADIANCE\nSOFTWARE=Lobe\nFORMAT=32-bit_rle_rgbe\n{mapping}\n-Y {height} +X {width}\n");
    let mut bytes = header.into_bytes();
    for row in texels.chunks_exact(width) {
        let row: Vec<[u8; 4]> = row.iter().map(|texel| rgbe::encode(*texel)).collect();
        rgbe::write_row(&row, &mut bytes);
    }
    Ok((bytes, report))
}

fn encode_exr(
    width: usize,
    (pixels, alpha): (&[impl IntoPixel], Option<&[f32]>),
    options: &PictureWriteOptions,
) -> exr::error::Result<(Vec<u8>, PictureWriteReport)> {
    let mapping = options.mapping.as_deref();
    if options.half {
        let (texels, report) = clamped(pixels, f16::MIN.to_f32(), f16::MAX.to_f32());
        return Ok((write_exr::encode(&texels, alpha, width, true, mapping)?, report));
    }
    Ok((write_exr::encode(pixels, alpha, width, false, mapping)?, PictureWriteReport::default()))
}

/// Portable float map: a header of three lines, then little-endian `f32`, the lowest row first.
fn encode_pfm(width: usize, pixels: &[impl IntoPixel]) -> (Vec<u8>, PictureWriteReport) {
    let mut bytes = format!("PF\n{width} {}\n-1.0\n", pixels.len() / width).into_bytes();
    for row in pixels.chunks_exact(width).rev() {
        bytes.extend(row.iter().flat_map(|t| (*t).into()).flat_map(f32::to_le_bytes));
    }
    (bytes, PictureWriteReport::default())
}
