//! JPEG XL decoder.
//!
//! The library tone-maps what is brighter than a display unless it is asked for a curve of bright displays, and clips where it converts
//! primaries. Pictures keep their own primaries here. Bright ones are asked for in PQ, which is undone; others as linear light.

use jxl_oxide::color::{
    ColourEncoding, ColourSpace, Customxy, Primaries as JxlPrimaries, TransferFunction, WhitePoint,
};
use jxl_oxide::{AllocTracker, EnumColourEncoding, JxlImage, RenderingIntent};

use crate::error::ImageError;
use crate::header::decoded::{Decoded, PictureHead, check_size, invalid, reserve, unsupported};
use crate::header::icc::Profile;
use crate::header::png_color::DIFFUSE_WHITE;
use crate::picture::primaries::Primaries;
use crate::picture::srgb::srgb_decode;
use crate::pixel::Pixel;

/// The luminance of 1 where a picture says nothing, in cd/m²: above it a picture is bright.
const DISPLAY_WHITE: f32 = 255.0;

/// Bytes that decoding takes for each texel: channels of 32 bits, for several passes and the result.
const BYTES_PER_TEXEL: usize = 96;

/// Bytes that decoding takes whatever the size: groups of texels at a time.
const BYTES_AT_LEAST: usize = 256 << 20;

/// Decodes a JPEG XL picture; `name` stands for the file in messages.
pub(crate) fn decode(bytes: &[u8], name: &str, max_texels: usize) -> Result<Decoded, ImageError> {
    let damaged = |error: &dyn std::fmt::Display| invalid(name, format!("damaged JPEG XL picture: {error}"));
    let tracker = AllocTracker::with_limit(max_texels.saturating_mul(BYTES_PER_TEXEL).saturating_add(BYTES_AT_LEAST));
    let mut image = JxlImage::builder().alloc_tracker(tracker).read(bytes).map_err(|error| damaged(&error))?;
    let (width, height) = check_size(image.width().into(), image.height().into(), max_texels, name)?;
    if image.num_loaded_keyframes() == 0 || !image.is_loading_done() {
        return Err(invalid(name, "the file ends early: the JPEG XL picture is not all there".into()));
    }
    if image.pixel_format().has_black() {
        return Err(unsupported(name, "a JPEG XL of gray or of RGB expected, found inks (CMYK)".into()));
    }
    let scale = Scale::of(&image);
    let own = own_encoding(&image);
    if let Some(own) = &own {
        let tf = if scale.is_pq { TransferFunction::Pq } else { TransferFunction::Linear };
        image.request_color_encoding(EnumColourEncoding { tf, ..own.clone() });
    }
    let profile = image.original_icc().filter(|_| own.is_none()).map(Profile::parse);
    let render = image.render_frame(0).map_err(|error| damaged(&error.to_string()))?;
    let mut stream = render.stream_no_alpha();
    let channels = stream.channels() as usize;
    let mut raw: Vec<f32> = reserve(width * height * channels, name)?;
    raw.resize(width * height * channels, 0.0);
    stream.write_to_buffer(&mut raw);
    let mut texels: Vec<Pixel> = reserve(width * height, name)?;
    texels.extend(raw.chunks_exact(channels).map(|texel| {
        let color = if channels < 3 { [texel[0]; 3] } else { [texel[0], texel[1], texel[2]] };
        color.map(|value| match profile.as_ref() {
            Some(Some(profile)) => profile.curve.light(value.into()) as f32,
            Some(None) => srgb_decode(value.into()) as f32,
            None => scale.light(value),
        })
    }));
    let mut head = PictureHead { notes: notes(&image, &scale), ..PictureHead::new(width, height) };
    let is_color = channels >= 3;
    match (profile, own) {
        (Some(None), _) if is_color => head.unclear_primaries = Some("the color profile".into()),
        (Some(profile), _) => {
            head.primaries = profile.map(|profile| ("the primaries of the color profile", profile.primaries));
        }
        (None, Some(own)) if is_color => {
            head.primaries = primaries_of(&own).map(|primaries| ("the primaries of the header", primaries));
        }
        _ => {}
    }
    Ok(Decoded { head, texels })
}

/// What a value that the library gives stands for.
struct Scale {
    /// Whether the library gives values of PQ rather than light.
    is_pq: bool,
    /// The luminance of 1, in cd/m².
    white: f64,
}

impl Scale {
    fn of(image: &JxlImage) -> Self {
        let target = image.image_header().metadata.tone_mapping.intensity_target;
        let is_encoded = image.hdr_type().is_some();
        Self {
            is_pq: is_encoded || target > DISPLAY_WHITE,
            white: if is_encoded { DIFFUSE_WHITE } else { target.into() },
        }
    }

    fn light(&self, value: f32) -> f32 {
        if self.is_pq { (luminance_of_pq(value.into()) / self.white) as f32 } else { value }
    }
}

/// The colors in which a picture is asked for, its own; none where only a profile tells them. Those of a lossy picture, which is stored in
/// other coordinates (XYB), are of Rec. 709.
fn own_encoding(image: &JxlImage) -> Option<EnumColourEncoding> {
    let metadata = &image.image_header().metadata;
    match &metadata.colour_encoding {
        ColourEncoding::Enum(own) if !metadata.xyb_encoded => Some(own.clone()),
        _ if !metadata.xyb_encoded => None,
        _ => Some(EnumColourEncoding {
            colour_space: ColourSpace::Rgb,
            white_point: WhitePoint::D65,
            primaries: JxlPrimaries::Srgb,
            tf: TransferFunction::Linear,
            rendering_intent: RenderingIntent::Relative,
        }),
    }
}

/// The places of the primaries of a picture in the diagram of chromaticities.
fn primaries_of(own: &EnumColourEncoding) -> Option<Primaries> {
    let place = |at: &Customxy| [f64::from(at.x) * 1e-6, f64::from(at.y) * 1e-6];
    let white = match &own.white_point {
        WhitePoint::D65 => [0.3127, 0.3290],
        WhitePoint::E => [1.0 / 3.0, 1.0 / 3.0],
        WhitePoint::Dci => [0.314, 0.351],
        WhitePoint::Custom(at) => place(at),
    };
    let [red, green, blue] = match &own.primaries {
        JxlPrimaries::Srgb => [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]],
        JxlPrimaries::Bt2100 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]],
        JxlPrimaries::P3 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060]],
        JxlPrimaries::Custom { red, green, blue } => [place(red), place(green), place(blue)],
    };
    Primaries::new(red, green, blue, white)
}

/// The luminance of a value of PQ, in cd/m² (SMPTE ST 2084, equation 4.1).
fn luminance_of_pq(value: f64) -> f64 {
    const M1: f64 = 2610.0 / 16384.0;
    const M2: f64 = 2523.0 / 4096.0 * 128.0;
    const C1: f64 = 3424.0 / 4096.0;
    const C2: f64 = 2413.0 / 4096.0 * 32.0;
    const C3: f64 = 2392.0 / 4096.0 * 32.0;
    let root = value.abs().powf(1.0 / M2);
    // Colors outside of the gamut have negative channels, which lie mirrored.
    (10_000.0 * ((root - C1).max(0.0) / (C2 - C3 * root)).powf(1.0 / M1)).copysign(value)
}

fn notes(image: &JxlImage, scale: &Scale) -> Vec<String> {
    let metadata = &image.image_header().metadata;
    let is_float = matches!(metadata.bit_depth, jxl_oxide::image::BitDepth::FloatSample { .. });
    let mut notes = Vec::new();
    if image.hdr_type().is_some() {
        notes.push(format!("JPEG XL encoded by PQ or HLG: diffuse white, {DIFFUSE_WHITE} cd/m², is 1"));
    } else if !is_float && !scale.is_pq {
        let bits = metadata.bit_depth.bits_per_sample();
        notes.push(format!("JPEG XL of {bits} bits: white is 1, and whatever was brighter has been cut off"));
    }
    if image.pixel_format().has_alpha() {
        notes.push("alpha is ignored".into());
    }
    if image.num_loaded_keyframes() > 1 {
        notes.push("the file holds several frames; the first is read".into());
    }
    notes
}
