//! TIFF decoder: light as floating-point numbers, or values of 8 or 16 bits encoded for displays.

use std::io::Cursor;

use tiff::ColorType;
use tiff::TiffError;
use tiff::decoder::{BufferLayoutPreference, Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use crate::ImageError;
use crate::header::decoded::{Decoded, PictureHead, check_size, invalid, reserve, unsupported};
use crate::header::icc::Profile;
use crate::header::orientation::Orientation;
use crate::header::xmp;
use crate::picture::primaries::Primaries;
use crate::picture::srgb::srgb_decode;
use crate::pixel::Pixel;

/// A compressed byte stands for fewer bytes: Deflate expands to at most 1032, and LZW has codes of 12 bits for up to 4094.
const MOST_BYTES_PER_BYTE: usize = 4096;

/// The longest value of a tag, such as a packet of XMP or a profile.
const LONGEST_VALUE: usize = 64 << 20;

/// The tag of a packet of XMP.
const XMP: Tag = Tag::Unknown(700);

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
    limits.decoding_buffer_size = layout.complete_len;
    limits.intermediate_buffer_size = layout.complete_len.max(limits.intermediate_buffer_size);
    limits.ifd_value_size = LONGEST_VALUE;
    let mut reader = reader.with_limits(limits);
    let mut head = head(&mut reader, [width, height]);
    let orientation = Orientation::of_number(reader.find_tag_unsigned(Tag::Orientation).ok().flatten());
    let mut samples = DecodingResult::U8(Vec::new());
    let layout = reader.read_image_to_buffer(&mut samples).map_err(explain)?;
    let texels = light(&samples, &colors, &layout, [width, height], &mut head.notes, name)?;
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
    colors: &Colors,
    layout: &BufferLayoutPreference,
    size: [usize; 2],
    notes: &mut Vec<String>,
    name: &str,
) -> Result<Vec<Pixel>, ImageError> {
    let mut display = |bits: usize| {
        notes.push(format!(
            "TIFF of {bits} bits, decoded from sRGB: white is 1, and whatever was brighter has been cut off"
        ));
    };
    let picture = Picture { colors, planes: layout.planes, size, name };
    match samples {
        DecodingResult::F16(values) => picture.texels(values, |value| value.to_f32()),
        DecodingResult::F32(values) => picture.texels(values, |value| *value),
        DecodingResult::F64(values) => picture.texels(values, |value| *value as f32),
        DecodingResult::U8(values) => {
            display(8);
            let table: Vec<_> = (0..=u8::MAX).map(|v| srgb_decode(f64::from(v) / 255.0) as f32).collect();
            picture.texels(values, |value| table[usize::from(*value)])
        }
        DecodingResult::U16(values) => {
            display(16);
            let table: Vec<_> = (0..=u16::MAX).map(|v| srgb_decode(f64::from(v) / 65535.0) as f32).collect();
            picture.texels(values, |value| table[usize::from(*value)])
        }
        _ => {
            let message =
                format!("a TIFF of floating-point numbers, 8 or 16 bits expected, found other integers; {CONVERT}");
            Err(unsupported(name, message))
        }
    }
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
fn head(reader: &mut Reader<'_>, [width, height]: [usize; 2]) -> PictureHead {
    let mut head = PictureHead::new(width, height);
    if let Ok(packet) = reader.get_tag_u8_vec(XMP) {
        xmp::add_packet(&packet, &mut head.panorama, &mut head.notes);
    }
    let primaries = reader.get_tag_f64_vec(Tag::Unknown(319)).ok();
    let white = reader.get_tag_f64_vec(Tag::Unknown(318)).ok();
    if let (Some(&[rx, ry, gx, gy, bx, by]), Some(&[wx, wy])) = (primaries.as_deref(), white.as_deref()) {
        let declared = Primaries::new([rx, ry], [gx, gy], [bx, by], [wx, wy]);
        head.primaries = declared.map(|primaries| ("the primaries of the tag PrimaryChromaticities", primaries));
    } else if let Ok(profile) = reader.get_tag_u8_vec(Tag::IccProfile) {
        let profile = Profile::parse(&profile);
        if profile.is_none() {
            head.notes.push("the color profile is ignored; the primaries of Rec. 709 are assumed".into());
        }
        head.primaries = profile.map(|profile| ("the primaries of the color profile", profile.primaries));
    }
    if reader.more_images() {
        head.notes.push("the file holds several pictures; the first is read".into());
    }
    head
}
