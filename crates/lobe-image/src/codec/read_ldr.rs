//! PNG and JPEG decoders: 8 or 16 bits, sRGB-encoded.

use std::io::Cursor;

use image::codecs::jpeg::JpegDecoder;
use image::codecs::png::PngDecoder;
use image::metadata::Orientation;
use image::{ColorType, ImageDecoder};
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::ImageError;
use crate::codec::decoded::{Decoded, check_size, invalid, reserve, unsupported};
use crate::codec::jpeg_end;
use crate::pixel::Pixel;
use crate::srgb_decode;

/// Deflate expands a byte to at most 1032, and PNG stores at most eight texels in a byte.
const MOST_PNG_TEXELS_PER_BYTE: u64 = 8 * 1032;

/// JPEG stores at least one bit for each block of 8 x 8 texels, in its densest form, a progressive picture of one
/// color; twice that.
const MOST_JPEG_TEXELS_PER_BYTE: u64 = 2 * 8 * 64;

/// Decodes a PNG picture; `name` stands for the file in messages.
pub(crate) fn decode_png(bytes: &[u8], name: &str, max_texels: usize) -> Result<Decoded, ImageError> {
    let within = image::Limits::default();
    let decoder = PngDecoder::with_limits(Cursor::new(bytes), within).map_err(|e| explain(&e, "PNG", name))?;
    let read = |decoder: PngDecoder<_>, raw: &mut [u8]| decoder.read_image(raw).map_err(|e| explain(&e, "PNG", name));
    decode(decoder, bytes.len(), MOST_PNG_TEXELS_PER_BYTE, "PNG", name, max_texels, read)
}

/// Decodes a JPEG picture; `name` stands for the file in messages.
pub(crate) fn decode_jpeg(bytes: &[u8], name: &str, max_texels: usize) -> Result<Decoded, ImageError> {
    let decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(|e| explain(&e, "JPEG", name))?;
    let Some(picture) = jpeg_end::with_ones_behind(bytes) else {
        return Err(invalid(name, "the file ends early: the end of the JPEG picture is missing".into()));
    };
    // `image` decodes what it finds, and fills the rest with gray.
    let read = |decoder: JpegDecoder<_>, raw: &mut [u8]| {
        let colors = if decoder.color_type() == ColorType::L8 { ColorSpace::Luma } else { ColorSpace::RGB };
        let options = DecoderOptions::default().set_strict_mode(true).jpeg_set_out_colorspace(colors);
        let options = options.set_max_width(usize::MAX).set_max_height(usize::MAX);
        let mut strict = zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(picture.as_slice()), options);
        let damaged = |e| invalid(name, format!("the JPEG picture is damaged or not all there: {e}"));
        strict.decode_into(raw).map_err(damaged)
    };
    decode(decoder, bytes.len(), MOST_JPEG_TEXELS_PER_BYTE, "JPEG", name, max_texels, read)
}

fn decode<D: ImageDecoder>(
    mut decoder: D,
    length: usize,
    most_texels_per_byte: u64,
    kind: &str,
    name: &str,
    max_texels: usize,
    read: impl FnOnce(D, &mut [u8]) -> Result<(), ImageError>,
) -> Result<Decoded, ImageError> {
    let (width, height) = decoder.dimensions();
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let (width, height) = if is_lying(orientation) { (height, width) } else { (width, height) };
    let (width, height) = check_size(width.into(), height.into(), max_texels, name)?;
    let count = width * height;
    if count as u64 > (length as u64).saturating_mul(most_texels_per_byte) {
        let message = format!("the file ends early: {width} x {height} texels cannot be in {length} bytes");
        return Err(invalid(name, message));
    }
    let color = decoder.color_type();
    let notes = notes(&mut decoder, kind);
    let raw_bytes = count * usize::from(color.bytes_per_pixel());
    let mut raw = reserve(raw_bytes, name)?;
    let mut texels = reserve(count, name)?;
    raw.resize(raw_bytes, 0);
    read(decoder, &mut raw)?;

    let channels = usize::from(color.channel_count());
    match color {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            let linear: Vec<f32> = (0..=u8::MAX).map(|c| srgb_decode(f64::from(c) / 255.0) as f32).collect();
            texels.extend(raw.chunks_exact(channels).map(|texel| rgb(texel, |c| linear[usize::from(*c)])));
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            let linear: Vec<f32> = (0..=u16::MAX).map(|c| srgb_decode(f64::from(c) / 65535.0) as f32).collect();
            let values = raw.as_chunks::<2>().0;
            texels.extend(
                values.chunks_exact(channels).map(|texel| rgb(texel, |c| linear[usize::from(u16::from_ne_bytes(*c))])),
            );
        }
        other => return Err(unsupported(name, format!("8 or 16 bits in gray or RGB expected, found {other:?}"))),
    }
    if orientation != Orientation::NoTransforms {
        texels = upright(&texels, [width, height], orientation, name)?;
    }
    Ok(Decoded { width, height, texels, notes, envmap: None })
}

/// Whether the orientation swaps columns and rows.
fn is_lying(orientation: Orientation) -> bool {
    use Orientation::{Rotate90, Rotate90FlipH, Rotate270, Rotate270FlipH};
    matches!(orientation, Rotate90 | Rotate270 | Rotate90FlipH | Rotate270FlipH)
}

/// The texels of the upright picture, which has the given size, from those of the stored one.
fn upright(
    stored: &[Pixel],
    [width, height]: [usize; 2],
    orientation: Orientation,
    name: &str,
) -> Result<Vec<Pixel>, ImageError> {
    let (right, bottom) = (width - 1, height - 1);
    // The number of stored columns, and the index of a texel among the stored ones.
    let columns = if is_lying(orientation) { height } else { width };
    let place = |x: usize, y: usize| match orientation {
        Orientation::NoTransforms => [x, y],
        Orientation::FlipHorizontal => [right - x, y],
        Orientation::Rotate180 => [right - x, bottom - y],
        Orientation::FlipVertical => [x, bottom - y],
        Orientation::Rotate90FlipH => [y, x],
        Orientation::Rotate90 => [y, right - x],
        Orientation::Rotate270FlipH => [bottom - y, right - x],
        Orientation::Rotate270 => [bottom - y, x],
    };
    let mut texels = reserve(width * height, name)?;
    for y in 0..height {
        texels.extend((0..width).map(|x| {
            let [x, y] = place(x, y);
            stored[y * columns + x]
        }));
    }
    Ok(texels)
}

/// Gray, or the first three channels.
fn rgb<T>(texel: &[T], linear: impl Fn(&T) -> f32) -> Pixel {
    if texel.len() < 3 {
        let gray = linear(&texel[0]);
        return [gray; 3];
    }
    [linear(&texel[0]), linear(&texel[1]), linear(&texel[2])]
}

/// Remarks for the caller.
fn notes(decoder: &mut impl ImageDecoder, kind: &str) -> Vec<String> {
    let bits = 8 * u32::from(decoder.color_type().bytes_per_pixel() / decoder.color_type().channel_count());
    let mut notes = vec![format!(
        "{kind} of {bits} bits, decoded from sRGB: white is 1, and whatever was brighter has been cut off"
    )];
    if decoder.color_type().has_alpha() {
        notes.push("alpha is ignored".into());
    }
    if matches!(decoder.icc_profile(), Ok(Some(_))) {
        notes.push("the color profile is ignored; sRGB is assumed".into());
    }
    if matches!(decoder.orientation(), Ok(o) if o != Orientation::NoTransforms) {
        notes.push("turned upright, as the camera noted".into());
    }
    notes
}

/// Translates an error of the decoder.
fn explain(error: &image::ImageError, kind: &str, name: &str) -> ImageError {
    match error {
        image::ImageError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            invalid(name, format!("the file ends early: the {kind} picture is not all there"))
        }
        image::ImageError::Unsupported(e) => unsupported(name, format!("this kind of {kind} is not read: {e}")),
        other => invalid(name, format!("damaged {kind} picture: {other}")),
    }
}
