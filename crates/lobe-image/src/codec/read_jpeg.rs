//! JPEG decoder: 8 bits encoded for displays, and the light above white where a gain map tells of it.

use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::codec::gain_map::{self, Found, GainMap};
use crate::codec::jpeg_end;
use crate::codec::read_ldr::{CUT_OFF, Layout, check};
use crate::error::ImageError;
use crate::header::decoded::{Decoded, PictureHead, invalid, reserve, unsupported};
use crate::header::icc::Profile;
use crate::header::orientation::Orientation;
use crate::header::png_color::Transfer;
use crate::header::xmp::{self, Panorama};
use crate::picture::primaries::Primaries;
use crate::pixel::Pixel;

/// JPEG stores at least one bit for each block of 8 x 8 texels, in its densest form, a progressive picture of one
/// color; twice that.
const MOST_TEXELS_PER_BYTE: u64 = 2 * 8 * 64;

/// Decodes a JPEG picture; `name` stands for the file in messages.
pub(crate) fn decode(bytes: &[u8], name: &str, max_texels: usize) -> Result<Decoded, ImageError> {
    let jpeg = Jpeg::open(bytes, name, max_texels)?;
    let (mut panorama, mut notes) = (Panorama::new(), Vec::new());
    let info = jpeg.headers.info();
    // What does not fit a segment of 64 KiB is in others, which the decoder puts together.
    let packets = info.iter().flat_map(|info| [&info.xmp_data, &info.extended_xmp]);
    packets.flatten().for_each(|packet| xmp::add_packet(packet, &mut panorama, &mut notes));
    let gain = match gain_map::find(bytes) {
        Found::Nothing => None,
        Found::Map(map, picture) => Some(Gain::decode(map, picture, max_texels - jpeg.texels())),
        Found::Unusable(why) => Some(Err(why.to_owned())),
    };
    let gain = gain.and_then(|gain| gain.map_err(|why| notes.push(format!("its gain map is not used: {why}"))).ok());
    let above_white = gain.as_ref().map_or(CUT_OFF.to_owned(), |gain| {
        format!("its gain map tells of up to {:.3} times that", gain.map.stops().exp2())
    });
    let layout = jpeg.layout(above_white);
    let mut decoded = layout.decode(name, |raw| jpeg.decode_into(raw, name))?;
    if let Some(gain) = gain {
        let own = decoded.head.primaries.map(|(_, primaries)| primaries);
        if !gain.map.is_in_base_colors && gain.primaries.is_some() && gain.primaries != own {
            notes.push("its gain map is in the colors of another profile, and applied in those of the picture".into());
        }
        gain.brighten(&mut decoded, layout.orientation, name)?;
    }
    decoded.head.notes.append(&mut notes);
    Ok(Decoded { head: PictureHead { panorama, ..decoded.head }, ..decoded })
}

/// A JPEG whose headers have been read.
struct Jpeg<'a> {
    headers: JpegDecoder<ZCursor<&'a [u8]>>,
    /// Its bytes, so that what is missing of its scan is found.
    bytes: Vec<u8>,
    size: [usize; 2],
    is_gray: bool,
}

impl<'a> Jpeg<'a> {
    fn open(bytes: &'a [u8], name: &str, max_texels: usize) -> Result<Self, ImageError> {
        let mut headers = JpegDecoder::new_with_options(ZCursor::new(bytes), options().set_strict_mode(false));
        headers.decode_headers().map_err(|error| match error {
            DecodeErrors::Unsupported(what) => unsupported(name, format!("this kind of JPEG is not read: {what:?}")),
            other => invalid(name, format!("damaged JPEG picture: {other}")),
        })?;
        let Some(whole) = jpeg_end::with_ones_behind(bytes) else {
            return Err(invalid(name, "the file ends early: the end of the JPEG picture is missing".into()));
        };
        let (width, height) = headers.dimensions().unwrap_or_default();
        let size = check(width as u64, height as u64, max_texels, bytes, MOST_TEXELS_PER_BYTE, name)?;
        let is_gray = headers.input_colorspace() == Some(ColorSpace::Luma);
        Ok(Self { headers, bytes: whole, size, is_gray })
    }

    fn texels(&self) -> usize {
        self.size[0] * self.size[1]
    }

    fn channels(&self) -> usize {
        if self.is_gray { 1 } else { 3 }
    }

    fn layout(&self, above_white: String) -> Layout {
        Layout {
            kind: "JPEG",
            size: self.size,
            channels: self.channels(),
            is_wide: false,
            transfer: Transfer::Srgb,
            orientation: self.headers.exif().map_or(Orientation::UPRIGHT, |exif| Orientation::of_exif(exif)),
            profile: self.headers.icc_profile().map(|profile| Profile::parse(&profile)),
            above_white,
        }
    }

    /// Fills in the values of the channels, texel by texel.
    fn decode_into(&self, raw: &mut [u8], name: &str) -> Result<(), ImageError> {
        let colors = if self.is_gray { ColorSpace::Luma } else { ColorSpace::RGB };
        // Where it need not be strict, the decoder fills what is missing with gray.
        let strict = options().set_strict_mode(true).jpeg_set_out_colorspace(colors);
        let damaged = |e| invalid(name, format!("the JPEG picture is damaged or not all there: {e}"));
        JpegDecoder::new_with_options(ZCursor::new(self.bytes.as_slice()), strict).decode_into(raw).map_err(damaged)
    }
}

/// A gain map, decoded.
struct Gain {
    map: GainMap,
    size: [usize; 2],
    /// Its values in [0, 1], as the first picture is stored.
    values: Vec<Pixel>,
    /// The primaries of its profile.
    primaries: Option<Primaries>,
}

impl Gain {
    /// Decodes the second picture; the text says why it cannot be used. The first picture is whole without it.
    fn decode(map: GainMap, picture: &[u8], max_texels: usize) -> Result<Self, String> {
        let unusable = |error: ImageError| error.to_string().replace("gain map: ", "");
        let second = Jpeg::open(picture, "gain map", max_texels).map_err(unusable)?;
        let channels = second.channels();
        let mut raw: Vec<u8> = reserve(second.texels() * channels, "gain map").map_err(unusable)?;
        raw.resize(second.texels() * channels, 0);
        second.decode_into(&mut raw, "gain map").map_err(unusable)?;
        let value = |value: u8| f32::from(value) / 255.0;
        let values = raw.chunks_exact(channels).map(|texel| match *texel {
            [r, g, b] => [r, g, b].map(value),
            _ => [value(texel[0]); 3],
        });
        let profile = second.headers.icc_profile().and_then(|profile| Profile::parse(&profile));
        let primaries = profile.map(|profile| profile.primaries);
        Ok(Self { map, size: second.size, values: values.collect(), primaries })
    }

    /// Makes a picture as bright as its gain map says. That lies as the picture is stored, whatever it says itself.
    fn brighten(self, decoded: &mut Decoded, orientation: Orientation, name: &str) -> Result<(), ImageError> {
        let size = orientation.upright_size(self.size);
        let values = if orientation == Orientation::UPRIGHT {
            self.values
        } else {
            orientation.upright(&self.values, size, name)?
        };
        self.map.apply(&mut decoded.texels, [decoded.head.width, decoded.head.height], &values, size);
        Ok(())
    }
}

fn options() -> DecoderOptions {
    DecoderOptions::default().set_max_width(usize::MAX).set_max_height(usize::MAX)
}
