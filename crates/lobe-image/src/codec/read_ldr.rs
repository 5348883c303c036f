//! PNG decoder, and the layout of pictures of 8 or 16 bits that are encoded for displays.

use std::io::{Cursor, ErrorKind};

use png::{BitDepth, DecodingError, Transformations};

use crate::error::ImageError;
use crate::header::decoded::{Decoded, PictureHead, check_size, invalid, reserve};
use crate::header::icc::{Curve, Profile};
use crate::header::orientation::Orientation;
use crate::header::png_color::{Transfer, has_coded_transfer, primaries_of_png};
use crate::header::xmp::{self, Panorama};
use crate::picture::png::MAPPING_KEY;
use crate::pixel::Pixel;

/// Deflate expands a byte to at most 1032, and PNG stores at most eight texels in a byte.
const MOST_PNG_TEXELS_PER_BYTE: u64 = 8 * 1032;

/// What a note says of light above white, where no file can tell of it.
pub(crate) const CUT_OFF: &str = "whatever was brighter has been cut off";

/// The remark on a profile that is not understood.
const CURVE_UNKNOWN: &str = "the color profile is ignored; the curve of sRGB is assumed";

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
    let profile = info.icc_profile.as_deref().map(Profile::parse);
    // Of a gray picture a profile says nothing of primaries.
    let of_color = profile.as_ref().filter(|profile| profile.is_some() || color.samples() >= 3);
    let declared = primaries_of_png(info, of_color);
    let layout = Layout {
        kind: "PNG",
        size,
        channels: color.samples(),
        is_wide: depth == BitDepth::Sixteen,
        transfer: Transfer::of_png(info, name)?,
        orientation: info.exif_metadata.as_deref().map_or(Orientation::UPRIGHT, Orientation::of_exif),
        // A transfer function of cICP stands in place of the curve of a profile.
        profile: profile.filter(|_| !has_coded_transfer(info)),
        above_white: CUT_OFF.to_owned(),
    };
    let (primaries, unclear_primaries) = match declared {
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
    // What is not understood of a profile is its curve too, also where cICP tells the primaries.
    if decoded.head.unclear_primaries.is_some() && unclear_primaries.is_none() {
        decoded.head.notes.push(CURVE_UNKNOWN.into());
    }
    Ok(Decoded { head: PictureHead { primaries, unclear_primaries, mapping, panorama, ..decoded.head }, ..decoded })
}

/// Refuses a picture larger than the caller allows, or than the bytes of its file can hold.
pub(crate) fn check(
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
pub(crate) struct Layout {
    pub(crate) kind: &'static str,
    /// The columns and rows that are stored.
    pub(crate) size: [usize; 2],
    /// Gray or three colors, with alpha if they are 2 or 4.
    pub(crate) channels: usize,
    /// Whether a channel has 16 bits, the higher eight first, rather than 8.
    pub(crate) is_wide: bool,
    pub(crate) transfer: Transfer,
    pub(crate) orientation: Orientation,
    /// The color profile; none within if it is not understood.
    pub(crate) profile: Option<Option<Profile>>,
    /// What becomes of light above white, for a note.
    pub(crate) above_white: String,
}

impl Layout {
    /// The picture whose bytes `read` fills in.
    pub(crate) fn decode(
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
        let linear =
            |most: u16| -> Vec<f32> { (0..=most).map(|c| self.light(f64::from(c) / f64::from(most)) as f32).collect() };
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
        let primaries = self.understood().map(|profile| ("the primaries of the color profile", profile.primaries));
        let is_unclear = matches!(self.profile, Some(None)) && self.channels >= 3;
        let unclear_primaries = is_unclear.then(|| "the color profile".to_owned());
        let head = PictureHead { notes: self.notes(), primaries, unclear_primaries, ..PictureHead::new(width, height) };
        Ok(Decoded { head, texels })
    }

    /// The profile, if there is one that is understood.
    fn understood(&self) -> Option<&Profile> {
        self.profile.as_ref()?.as_ref()
    }

    /// The curve of the profile.
    fn curve(&self) -> Option<&Curve> {
        self.understood().map(|profile| &profile.curve)
    }

    /// The light of a value of [0, 1].
    fn light(&self, value: f64) -> f64 {
        self.curve().map_or_else(|| self.transfer.light(value), |curve| curve.light(value))
    }

    /// Remarks for the caller.
    fn notes(&self) -> Vec<String> {
        let bits = if self.is_wide { 16 } else { 8 };
        let decoded = match self.curve() {
            Some(Curve::Tag(_)) => "decoded by the curve of its color profile".to_owned(),
            Some(Curve::Linear) => "of linear light as its color profile says".to_owned(),
            Some(Curve::Srgb) | None => self.transfer.to_string(),
        };
        let mut notes = vec![format!("{} of {bits} bits, {decoded}: white is 1, and {}", self.kind, self.above_white)];
        if self.channels.is_multiple_of(2) {
            notes.push("alpha is ignored".into());
        }
        if matches!(self.profile, Some(None)) && self.channels < 3 {
            notes.push(CURVE_UNKNOWN.into());
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
