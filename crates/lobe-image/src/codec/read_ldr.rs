//! PNG and JPEG decoders: 8 or 16 bits, encoded for displays.

use std::io::{Cursor, ErrorKind};

use png::{BitDepth, DecodingError, Transformations};
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::ImageError;
use crate::codec::decoded::{Decoded, PictureHead, check_size, invalid, reserve, unsupported};
use crate::codec::jpeg_end;
use crate::codec::orientation::Orientation;
use crate::codec::png_color::{Transfer, UNSPECIFIED, primaries_of_png};
use crate::codec::xmp::{self, Panorama};
use crate::picture::png::MAPPING_KEY;
use crate::pixel::Pixel;

/// Deflate expands a byte to at most 1032, and PNG stores at most eight texels in a byte.
const MOST_PNG_TEXELS_PER_BYTE: u64 = 8 * 1032;

/// JPEG stores at least one bit for each block of 8 x 8 texels, in its densest form, a progressive picture of one
/// color; twice that.
const MOST_JPEG_TEXELS_PER_BYTE: u64 = 2 * 8 * 64;

/// The key of a text of a PNG that is a packet of XMP.
const XMP_KEY: &str = "XML:com.adobe.xmp";

/// The longest packet of XMP of a PNG.
const XMP_BYTES: usize = 16 << 20;

/// The most memory that the PNG decoder takes besides the picture, for a row, a profile and texts.
const PNG_BYTES: usize = 512 << 20;

/// Decodes a PNG picture; `name` stands for the file in messages.
pub(crate) fn decode_png(bytes: &[u8], name: &str, max_texels: usize) -> Result<Decoded, ImageError> {
    let explain = |error: DecodingError| match error {
        DecodingError::IoError(e) if e.kind() == ErrorKind::UnexpectedEof => {
            invalid(name, "the file ends early: the PNG picture is not all there".into())
        }
        other => invalid(name, format!("damaged PNG picture: {other}")),
    };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: PNG_BYTES });
    let (width, height) = decoder.read_header_info().map_err(explain)?.size();
    let size = check(width.into(), height.into(), max_texels, bytes, MOST_PNG_TEXELS_PER_BYTE, name)?;
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(explain)?;
    let (color, depth) = reader.output_color_type();
    let info = reader.info();
    // A transfer function of cICP stands in place of a profile.
    let is_coded = info.coding_independent_code_points.is_some_and(|points| points.transfer_function != UNSPECIFIED);
    let layout = Layout {
        kind: "PNG",
        size,
        channels: color.samples(),
        is_wide: depth == BitDepth::Sixteen,
        transfer: Transfer::of_png(info, name)?,
        orientation: info.exif_metadata.as_deref().map_or(Orientation::UPRIGHT, Orientation::of_exif),
        has_profile: info.icc_profile.is_some() && !is_coded,
    };
    let (primaries, unclear_primaries) = match primaries_of_png(info) {
        Some(Ok(primaries)) => (Some(primaries), None),
        Some(Err(unclear)) => (None, Some(unclear)),
        None => (None, None),
    };
    let texts = &info.uncompressed_latin1_text;
    let mapping = texts.iter().find(|text| text.keyword == MAPPING_KEY).map(|text| text.text.clone());
    let (mut panorama, mut unclear) = (Panorama::new(), Vec::new());
    for text in info.utf8_text.iter().filter(|text| text.keyword == XMP_KEY) {
        let mut text = text.clone();
        let packet = text.decompress_text_with_limit(XMP_BYTES).and_then(|()| text.get_text());
        xmp::add_packet(packet.unwrap_or_default().as_bytes(), &mut panorama, &mut unclear);
    }
    let mut decoded = layout.decode(name, |raw| reader.next_frame(raw).map(|_| ()).map_err(explain))?;
    decoded.head.notes.append(&mut unclear);
    Ok(Decoded { head: PictureHead { primaries, unclear_primaries, mapping, panorama, ..decoded.head }, ..decoded })
}

/// Decodes a JPEG picture; `name` stands for the file in messages.
pub(crate) fn decode_jpeg(bytes: &[u8], name: &str, max_texels: usize) -> Result<Decoded, ImageError> {
    let options = DecoderOptions::default().set_max_width(usize::MAX).set_max_height(usize::MAX);
    let lenient = options.set_strict_mode(false);
    let mut headers = zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(bytes), lenient);
    headers.decode_headers().map_err(|error| match error {
        DecodeErrors::Unsupported(what) => unsupported(name, format!("this kind of JPEG is not read: {what:?}")),
        other => invalid(name, format!("damaged JPEG picture: {other}")),
    })?;
    let Some(picture) = jpeg_end::with_ones_behind(bytes) else {
        return Err(invalid(name, "the file ends early: the end of the JPEG picture is missing".into()));
    };
    let (width, height) = headers.dimensions().unwrap_or_default();
    let size = check(width as u64, height as u64, max_texels, bytes, MOST_JPEG_TEXELS_PER_BYTE, name)?;
    let (mut panorama, mut unclear) = (Panorama::new(), Vec::new());
    let info = headers.info();
    // What does not fit a segment of 64 KiB is in others, which the decoder puts together.
    let packets = info.iter().flat_map(|info| [&info.xmp_data, &info.extended_xmp]);
    packets.flatten().for_each(|packet| xmp::add_packet(packet, &mut panorama, &mut unclear));
    let is_gray = headers.input_colorspace() == Some(ColorSpace::Luma);
    let layout = Layout {
        kind: "JPEG",
        size,
        channels: if is_gray { 1 } else { 3 },
        is_wide: false,
        transfer: Transfer::Srgb,
        orientation: headers.exif().map_or(Orientation::UPRIGHT, |exif| Orientation::of_exif(exif)),
        has_profile: headers.icc_profile().is_some(),
    };
    // Where it need not be strict, the decoder fills what is missing with gray.
    let mut decoded = layout.decode(name, |raw| {
        let colors = if is_gray { ColorSpace::Luma } else { ColorSpace::RGB };
        let strict = options.set_strict_mode(true).jpeg_set_out_colorspace(colors);
        let mut decoder = zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(picture.as_slice()), strict);
        let damaged = |e| invalid(name, format!("the JPEG picture is damaged or not all there: {e}"));
        decoder.decode_into(raw).map_err(damaged)
    })?;
    decoded.head.notes.append(&mut unclear);
    Ok(Decoded { head: PictureHead { panorama, ..decoded.head }, ..decoded })
}

/// Refuses a picture larger than the caller allows, or than the bytes of its file can hold.
fn check(
    width: u64,
    height: u64,
    max_texels: usize,
    bytes: &[u8],
    most_texels_per_byte: u64,
    name: &str,
) -> Result<[usize; 2], ImageError> {
    let (width, height) = check_size(width, height, max_texels, name)?;
    if (width * height) as u64 <= (bytes.len() as u64).saturating_mul(most_texels_per_byte) {
        return Ok([width, height]);
    }
    let message = format!("the file ends early: {width} x {height} texels cannot be in {} bytes", bytes.len());
    Err(invalid(name, message))
}

/// The bytes of a decoded picture, row by row, and what else its header says.
struct Layout {
    kind: &'static str,
    /// The columns and rows that are stored.
    size: [usize; 2],
    /// Gray or three colors, with alpha if they are 2 or 4.
    channels: usize,
    /// Whether a channel has 16 bits, the higher eight first, rather than 8.
    is_wide: bool,
    transfer: Transfer,
    orientation: Orientation,
    has_profile: bool,
}

impl Layout {
    /// The picture whose bytes `read` fills in.
    fn decode(
        &self,
        name: &str,
        read: impl FnOnce(&mut [u8]) -> Result<(), ImageError>,
    ) -> Result<Decoded, ImageError> {
        let count = self.size[0] * self.size[1];
        let raw_bytes = count * self.channels * if self.is_wide { 2 } else { 1 };
        let mut raw: Vec<u8> = reserve(raw_bytes, name)?;
        let mut texels: Vec<Pixel> = reserve(count, name)?;
        raw.resize(raw_bytes, 0);
        read(&mut raw)?;
        let linear = |most: u16| -> Vec<f32> {
            (0..=most).map(|c| self.transfer.light(f64::from(c) / f64::from(most)) as f32).collect()
        };
        if self.is_wide {
            let (linear, values) = (linear(u16::MAX), raw.as_chunks::<2>().0);
            let value = |c: &[u8; 2]| linear[usize::from(u16::from_be_bytes(*c))];
            texels.extend(values.chunks_exact(self.channels).map(|texel| rgb(texel, value)));
        } else {
            let linear = linear(u8::MAX.into());
            texels.extend(raw.chunks_exact(self.channels).map(|texel| rgb(texel, |c| linear[usize::from(*c)])));
        }
        let [width, height] = self.orientation.upright_size(self.size);
        if self.orientation != Orientation::UPRIGHT {
            texels = self.orientation.upright(&texels, [width, height], name)?;
        }
        Ok(Decoded { head: PictureHead { notes: self.notes(), ..PictureHead::new(width, height) }, texels })
    }

    /// Remarks for the caller.
    fn notes(&self) -> Vec<String> {
        let bits = if self.is_wide { 16 } else { 8 };
        let mut notes = vec![format!(
            "{} of {bits} bits, {}: white is 1, and whatever was brighter has been cut off",
            self.kind, self.transfer
        )];
        if self.channels.is_multiple_of(2) {
            notes.push("alpha is ignored".into());
        }
        if self.has_profile {
            notes.push("the color profile is ignored; sRGB is assumed".into());
        }
        if self.orientation != Orientation::UPRIGHT {
            notes.push("turned upright, as the camera noted".into());
        }
        notes
    }
}

/// Gray, or the first three channels.
fn rgb<T>(texel: &[T], linear: impl Fn(&T) -> f32) -> Pixel {
    if texel.len() < 3 {
        let gray = linear(&texel[0]);
        return [gray; 3];
    }
    [linear(&texel[0]), linear(&texel[1]), linear(&texel[2])]
}
