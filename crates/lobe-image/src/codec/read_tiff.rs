//! TIFF decoder: light as floating-point numbers, or values of 8 or 16 bits encoded for displays.

use std::io::Cursor;

use tiff::ColorType;
use tiff::TiffError;
use tiff::decoder::ifd::Value;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use crate::codec::read_ldr::CUT_OFF;
use crate::error::ImageError;
use crate::header::decoded::{Decoded, PictureHead, check_size, invalid, reserve, unsupported};
use crate::header::icc::{Curve, Profile};
use crate::header::orientation::Orientation;
use crate::header::xmp;
use crate::picture::primaries::Primaries;
use crate::pixel::Pixel;

/// A compressed byte stands for fewer bytes: Deflate expands to at most 1032, and LZW has codes of 12 bits for up to 4094.
const MOST_BYTES_PER_BYTE: usize = 4096;

/// The longest value of a tag, such as a packet of XMP or a profile.
const LONGEST_VALUE: u64 = 4 << 20;

/// The tag of a packet of XMP.
const XMP: Tag = Tag::Unknown(700);

/// The tag of the places of red, green and blue in the diagram of chromaticities.
const PRIMARY_CHROMATICITIES: Tag = Tag::Unknown(319);

/// The tag of the place of white.
const WHITE_POINT: Tag = Tag::Unknown(318);

type Reader<'a> = Decoder<Cursor<&'a [u8]>>;

/// Decodes the first picture of a TIFF file; `name` stands for the file in messages.
pub(crate) fn decode(bytes: &[u8], name: &str, max_texels: usize) -> Result<Decoded, ImageError> {
    let explain = |error: TiffError| explained(&error, name);
    let mut reader = Decoder::new(Cursor::new(bytes)).map_err(explain)?;
    let (width, height) = reader.dimensions().map_err(explain)?;
    let (width, height) = check_size(width.into(), height.into(), max_texels, name)?;
    let colors = Colors::of(reader.colortype().map_err(explain)?, name)?;
    let layout = reader.image_buffer_layout().map_err(explain)?;
    if layout.complete_len / MOST_BYTES_PER_BYTE > bytes.len() {
        let message = format!("the file ends early: {width} x {height} texels cannot be in {} bytes", bytes.len());
        return Err(invalid(name, message));
    }
    let mut limits = Limits::default();
    limits.decoding_buffer_size = layout.complete_len.max(limits.decoding_buffer_size);
    limits.intermediate_buffer_size = layout.complete_len.max(limits.intermediate_buffer_size);
    let mut reader = reader.with_limits(limits);
    refuse_raw(&mut reader, name)?;
    let profile = bytes_of(&mut reader, Tag::IccProfile).map(|profile| Profile::parse(&profile));
    let mut head = head(&mut reader, &profile, [width, height]);
    let curve = profile.and_then(|profile| Some(profile?.curve));
    let orientation = Orientation::of_number(reader.find_tag_unsigned(Tag::Orientation).ok().flatten());
    let mut samples = DecodingResult::U8(Vec::new());
    let layout = reader.read_image_to_buffer(&mut samples).map_err(explain)?;
    let picture = Picture { colors: &colors, planes: layout.planes, size: [width, height], name };
    let texels = light(&samples, &picture, curve.as_ref(), &mut head.notes)?;
    if colors.has_alpha {
        head.notes.push("alpha is ignored".into());
    }
    if orientation == Orientation::UPRIGHT {
        return Ok(Decoded { head, texels });
    }
    head.notes.push("turned upright, as the file says".into());
    [head.width, head.height] = orientation.upright_size([width, height]);
    let texels = orientation.upright(&texels, [head.width, head.height], name)?;
    Ok(Decoded { head, texels })
}

fn explained(error: &TiffError, name: &str) -> ImageError {
    match error {
        TiffError::UnsupportedError(_) => {
            unsupported(name, format!("this kind of TIFF is not read: {error}; {CONVERT}"))
        }
        TiffError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            invalid(name, "the file ends early: the TIFF picture is not all there".into())
        }
        _ => invalid(name, format!("damaged TIFF picture: {error}")),
    }
}

/// What to do with a kind that is not read.
const CONVERT: &str = "convert it with `oiiotool IN.tif -o OUT.exr` or `magick IN.tif OUT.exr`";

/// The samples of a texel.
struct Colors {
    /// Of a texel, with alpha and whatever else is there.
    samples: usize,
    is_gray: bool,
    has_alpha: bool,
}

impl Colors {
    fn of(kind: ColorType, name: &str) -> Result<Self, ImageError> {
        let [samples, gray, alpha] = match kind {
            ColorType::Gray(_) => [1, 1, 0],
            ColorType::GrayA(_) => [2, 1, 1],
            ColorType::RGB(_) => [3, 0, 0],
            ColorType::RGBA(_) => [4, 0, 1],
            _ => {
                return Err(unsupported(name, format!("a TIFF of gray or of RGB expected, found {kind:?}; {CONVERT}")));
            }
        };
        Ok(Self { samples, is_gray: gray == 1, has_alpha: alpha == 1 })
    }
}

/// The texels of a picture, row by row, and a note that says what a value means.
fn light(
    samples: &DecodingResult,
    picture: &Picture<'_>,
    curve: Option<&Curve>,
    notes: &mut Vec<String>,
) -> Result<Vec<Pixel>, ImageError> {
    let mut table = |bits: u32| {
        let decoded = match curve {
            Some(Curve::Tag(_)) => "decoded by the curve of its color profile",
            Some(Curve::Linear) => "of linear light as its color profile says",
            Some(Curve::Srgb) | None => "decoded from sRGB",
        };
        notes.push(format!("TIFF of {bits} bits, {decoded}: white is 1, and {CUT_OFF}"));
        let (curve, most) = (curve.unwrap_or(&Curve::Srgb), (1_u32 << bits) - 1);
        (0..=most).map(|value| curve.light(f64::from(value) / f64::from(most)) as f32).collect::<Vec<_>>()
    };
    let encoded = curve.filter(|curve| !matches!(curve, Curve::Linear));
    let float = |value: f32| encoded.map_or(value, |curve| curve.light(value.into()) as f32);
    let texels = match samples {
        DecodingResult::F16(values) => picture.texels(values, |value| float(value.to_f32())),
        DecodingResult::F32(values) => picture.texels(values, |value| float(*value)),
        DecodingResult::F64(values) => picture.texels(values, |value| float(*value as f32)),
        DecodingResult::U8(values) => {
            let table = table(8);
            return picture.texels(values, |value| table[usize::from(*value)]);
        }
        DecodingResult::U16(values) => {
            let table = table(16);
            return picture.texels(values, |value| table[usize::from(*value)]);
        }
        _ => {
            let message = format!("a TIFF of floats, 8 or 16 bits expected, found other integers; {CONVERT}");
            return Err(unsupported(picture.name, message));
        }
    };
    if encoded.is_some() {
        notes.push("TIFF of floating-point numbers, decoded by the curve of its color profile".into());
    }
    texels
}

/// Refuses raw photographs, whose first picture is a thumbnail.
fn refuse_raw(reader: &mut Reader<'_>, name: &str) -> Result<(), ImageError> {
    const DNG_VERSION: Tag = Tag::Unknown(50706);
    // The bit of a picture that is a smaller one of another.
    let is_reduced = |bits: u32| bits & 1 == 1;
    let kind = reader.find_tag_unsigned::<u32>(Tag::NewSubfileType).ok().flatten();
    if kind.is_some_and(is_reduced) || reader.find_tag(DNG_VERSION).is_ok_and(|value| value.is_some()) {
        let message =
            "a raw photograph or another TIFF whose first picture is a thumbnail; develop it with `dcraw -4 -T IN`";
        return Err(unsupported(name, message.into()));
    }
    Ok(())
}

/// How the samples of a picture lie: texel by texel, or plane by plane.
struct Picture<'a> {
    colors: &'a Colors,
    planes: usize,
    size: [usize; 2],
    name: &'a str,
}

impl Picture<'_> {
    fn texels<T>(&self, values: &[T], light: impl Fn(&T) -> f32) -> Result<Vec<Pixel>, ImageError> {
        let count = self.size[0] * self.size[1];
        let (step, plane) = if self.planes > 1 { (1, count) } else { (self.colors.samples, 1) };
        if values.len() < count * self.colors.samples {
            return Err(invalid(self.name, "the TIFF picture is not all there".into()));
        }
        let channels = if self.colors.is_gray { [0; 3] } else { [0, plane, 2 * plane] };
        let mut texels = reserve(count, self.name)?;
        texels.extend((0..count).map(|i| channels.map(|channel| light(&values[i * step + channel]))));
        Ok(texels)
    }
}

/// What the tags say besides the texels.
fn head(reader: &mut Reader<'_>, profile: &Option<Option<Profile>>, [width, height]: [usize; 2]) -> PictureHead {
    let mut head = PictureHead::new(width, height);
    if let Some(packet) = bytes_of(reader, XMP) {
        xmp::add_packet(&packet, &mut head.panorama, &mut head.notes);
    }
    let [colors, white] = [PRIMARY_CHROMATICITIES, WHITE_POINT].map(|tag| numbers(reader, tag));
    if let Some(profile) = profile {
        head.primaries = profile.as_ref().map(|profile| ("the primaries of the color profile", profile.primaries));
        head.unclear_primaries = profile.is_none().then(|| "the color profile".to_owned());
    } else if colors.is_some() || white.is_some() {
        let declared = match (colors.as_deref(), white.as_deref()) {
            (Some(&[rx, ry, gx, gy, bx, by]), Some(&[wx, wy])) => {
                Primaries::new([rx, ry], [gx, gy], [bx, by], [wx, wy])
            }
            _ => None,
        };
        head.primaries = declared.map(|primaries| ("the primaries of the tag PrimaryChromaticities", primaries));
        head.unclear_primaries = declared.is_none().then(|| "the tag PrimaryChromaticities".to_owned());
    }
    if reader.more_images() {
        head.notes.push("the file holds several pictures; the first is read".into());
    }
    head
}

/// The bytes of a tag; an empty list where there are more than a file should have, as the library takes 32 bytes for
/// each.
fn bytes_of(reader: &mut Reader<'_>, tag: Tag) -> Option<Vec<u8>> {
    let entry = reader.image_ifd().find_entry(tag)?;
    if entry.count() > LONGEST_VALUE {
        return Some(Vec::new());
    }
    reader.get_tag_u8_vec(tag).ok()
}

/// The numbers of a tag, which are fractions by the standard and floats in some files.
fn numbers(reader: &mut Reader<'_>, tag: Tag) -> Option<Vec<f64>> {
    let number = |value: Value| match value {
        Value::Rational(n, d) => Some(f64::from(n) / f64::from(d)),
        Value::SRational(n, d) => Some(f64::from(n) / f64::from(d)),
        Value::Float(value) => Some(f64::from(value)),
        Value::Double(value) => Some(value),
        _ => None,
    };
    match reader.find_tag(tag).ok()?? {
        Value::List(values) => values.into_iter().map(number).collect(),
        value => Some(vec![number(value)?]),
    }
}
