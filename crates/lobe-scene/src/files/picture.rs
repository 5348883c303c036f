//! Pictures of scene files: PNG, JPEG, WebP, and KTX2 with Basis Universal textures.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

#[cfg(feature = "compressed")]
use basisu::{DecodeFlags, TargetFormat, Transcoder};
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::error::SceneError;
use crate::files::jpeg_end;
use crate::files::source::Source;
use crate::scene::texture::{Texture, Wrap};

const KTX2: &[u8] = &[0xAB, b'K', b'T', b'X', b' ', b'2', b'0'];

/// The number that a KTX2 has for the compression of its levels by Zstandard.
#[cfg(feature = "compressed")]
const ZSTANDARD: u32 = 2;

/// The most memory that the PNG decoder takes besides the picture, for a row, a profile and texts.
const PNG_BYTES: usize = 512 << 20;

/// Decodes a texture; `name` stands in messages.
pub(crate) fn decode(
    bytes: &[u8],
    name: &str,
    wrap: [Wrap; 2],
    source: &mut Source<'_>,
) -> Result<Texture, SceneError> {
    let (width, height, texels) =
        if bytes.starts_with(KTX2) { decode_ktx2(bytes, name, source)? } else { decode_picture(bytes, name, source)? };
    if texels.is_empty() {
        return Err(source.invalid(format!("{name}: a picture without texels")));
    }
    Ok(Texture::new(width as usize, height as usize, texels, wrap))
}

type Texels = (u32, u32, Vec<[u8; 4]>);

fn decode_picture(bytes: &[u8], name: &str, source: &mut Source<'_>) -> Result<Texels, SceneError> {
    let invalid = |error: &str, source: &Source<'_>| {
        source.invalid(format!("{name}: expected a PNG, JPEG, WebP or KTX2, found {error}"))
    };
    let ([width, height], decode) = open(bytes).map_err(|error| invalid(&error, source))?;
    source.count_texels(width, height)?;
    // A texel that is kept takes four bytes; decoding takes up to eight for its four numbers, and four for its bytes.
    source.check_bytes((u64::from(width) * u64::from(height)).saturating_mul(8 + 4))?;
    let decoded = catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|_| Err("damaged data".to_owned()));
    Ok((width, height, decoded.map_err(|error| invalid(&error, source))?))
}

/// What decodes a picture whose header has been read.
type Decode<'a> = Box<dyn FnOnce() -> Result<Vec<[u8; 4]>, String> + 'a>;

/// The columns and rows of a picture, and what decodes it.
fn open(bytes: &[u8]) -> Result<([u32; 2], Decode<'_>), String> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => open_png(bytes).map_err(|error| error.to_string()),
        [0xff, 0xd8, 0xff, ..] => open_jpeg(bytes),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => {
            open_webp(bytes).map_err(|error| error.to_string())
        }
        _ => Err("another kind of file".to_owned()),
    }
}

fn open_png(bytes: &[u8]) -> Result<([u32; 2], Decode<'_>), png::DecodingError> {
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: PNG_BYTES });
    decoder.set_transformations(png::Transformations::EXPAND);
    let (width, height) = decoder.read_header_info()?.size();
    let decode = move || {
        let mut reader = decoder.read_info()?;
        let (color, depth) = reader.output_color_type();
        let mut raw = vec![0; reader.output_buffer_size().ok_or(png::DecodingError::LimitsExceeded)?];
        reader.next_frame(&mut raw)?;
        if depth == png::BitDepth::Sixteen {
            // The nearest of 255 parts of the whole.
            let narrow = |value: &[u8; 2]| ((u32::from(u16::from_be_bytes(*value)) + 128) / 257) as u8;
            raw = raw.as_chunks().0.iter().map(narrow).collect();
        }
        Ok(rgba(&raw, color.samples()))
    };
    Ok(([width, height], Box::new(move || decode().map_err(|error: png::DecodingError| error.to_string()))))
}

fn open_jpeg(bytes: &[u8]) -> Result<([u32; 2], Decode<'_>), String> {
    let options = DecoderOptions::default().set_max_width(usize::MAX).set_max_height(usize::MAX);
    let mut headers = zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(bytes), options.set_strict_mode(false));
    headers.decode_headers().map_err(|error| error.to_string())?;
    let is_gray = headers.input_colorspace() == Some(ColorSpace::Luma);
    let (colors, channels) = if is_gray { (ColorSpace::Luma, 1) } else { (ColorSpace::RGB, 3) };
    let (width, height) = headers.dimensions().unwrap_or_default();
    let decode = move || {
        let Some(picture) = jpeg_end::with_ones_behind(bytes) else {
            return Err("a JPEG whose end is missing".to_owned());
        };
        // Where it need not be strict, the decoder fills what is missing with gray.
        let strict = options.set_strict_mode(true).jpeg_set_out_colorspace(colors);
        let mut decoder = zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(picture.as_slice()), strict);
        let raw = decoder.decode().map_err(|error| format!("a JPEG that is damaged or not all there: {error}"))?;
        Ok(rgba(&raw, channels))
    };
    // A side of a JPEG has sixteen bits.
    Ok(([width as u32, height as u32], Box::new(decode)))
}

fn open_webp(bytes: &[u8]) -> Result<([u32; 2], Decode<'_>), image_webp::DecodingError> {
    let mut decoder = image_webp::WebPDecoder::new(Cursor::new(bytes))?;
    let ((width, height), channels) = (decoder.dimensions(), if decoder.has_alpha() { 4 } else { 3 });
    let mut decode = move || {
        let mut raw = vec![0; decoder.output_buffer_size().ok_or(image_webp::DecodingError::ImageTooLarge)?];
        decoder.read_image(&mut raw)?;
        Ok(rgba(&raw, channels))
    };
    Ok(([width, height], Box::new(move || decode().map_err(|error: image_webp::DecodingError| error.to_string()))))
}

/// Texels of gray or three colors, with or without alpha.
fn rgba(raw: &[u8], channels: usize) -> Vec<[u8; 4]> {
    let texel = |texel: &[u8]| match *texel {
        [gray] => [gray, gray, gray, 255],
        [gray, alpha] => [gray, gray, gray, alpha],
        [r, g, b] => [r, g, b, 255],
        [r, g, b, alpha, ..] => [r, g, b, alpha],
        [] => [0; 4],
    };
    raw.chunks_exact(channels).map(texel).collect()
}

#[cfg(not(feature = "compressed"))]
fn decode_ktx2(_: &[u8], name: &str, source: &mut Source<'_>) -> Result<Texels, SceneError> {
    Err(source.unsupported(crate::files::built_without::message(&format!("{name}: a Basis Universal texture in KTX2"))))
}

/// The first level of a Basis Universal texture, the only kind that glTF allows in KTX2.
#[cfg(feature = "compressed")]
fn decode_ktx2(bytes: &[u8], name: &str, source: &mut Source<'_>) -> Result<Texels, SceneError> {
    let size = |at: usize| bytes.get(at..at + 4).and_then(|word| word.try_into().ok()).map_or(0, u32::from_le_bytes);
    // The header has the identifier, the format, the size of its type at 16, width, height, depth, layers, faces, levels
    // and at 44 the compression; at 80 where the first level is, its length, and at 96 its length when decompressed.
    let (width, height) = (size(20), size(24));
    source.count_texels(width, height)?;
    if size(32) > 1 || size(36) > 1 {
        return Err(source.invalid(format!("{name}: expected a plain picture in the KTX2, found layers or faces")));
    }
    // The library allocates what a level compressed by Zstandard claims: sixteen bytes for each block of 4 x 4.
    let most = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4)) * 16;
    let long = |at: usize| u64::from(size(at + 4)) << 32 | u64::from(size(at));
    // The library adds the two, whatever they are.
    if long(80).checked_add(long(88)).is_none_or(|end| end > bytes.len() as u64) {
        let message = format!(
            "{name}: expected the first level of the KTX2 within its {} bytes, found {} at byte {}",
            bytes.len(),
            long(88),
            long(80)
        );
        return Err(source.invalid(message));
    }
    let claimed = long(96);
    if size(44) == ZSTANDARD && claimed > most {
        let message = format!("{name}: expected at most {most} bytes in the first level of the KTX2, found {claimed}");
        return Err(source.invalid(message));
    }
    source.check_bytes(most)?;
    let decoded = catch_unwind(AssertUnwindSafe(|| {
        let texture = Transcoder::new(bytes).ok()?;
        texture.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).ok()
    }));
    match decoded {
        Ok(Some(texels)) if texels.len() as u64 == 4 * u64::from(width) * u64::from(height) => {
            Ok((width, height, texels.as_chunks().0.to_vec()))
        }
        _ => Err(source.unsupported(format!(
            "{name}: expected a Basis Universal texture in the KTX2: convert it with `ktx extract --level 0 IN OUT.png`"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use png::{BitDepth, ColorType};

    use super::*;

    /// Two texels as a PNG.
    fn png_of(color: ColorType, depth: BitDepth, palette: &[u8], raw: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if !palette.is_empty() {
            encoder.set_palette(palette);
            encoder.set_trns(&[255_u8, 51] as &[u8]);
        }
        encoder.write_header().unwrap().write_image_data(raw).unwrap();
        bytes
    }

    #[test]
    fn pictures_of_any_color_and_depth_become_four_channels_of_eight_bits() {
        use BitDepth::{Eight, One, Sixteen};
        let gray = [[0, 0, 0, 255], [255, 255, 255, 255]];
        let cases = [
            ("one bit", png_of(ColorType::Grayscale, One, &[], &[0b0100_0000]), gray),
            ("gray", png_of(ColorType::Grayscale, Eight, &[], &[0, 255]), gray),
            // A step of eight bits is 257 of these: 384 is nearer to one, 386 to two.
            (
                "sixteen bits",
                png_of(ColorType::GrayscaleAlpha, Sixteen, &[], &[0x01, 0x80, 255, 255, 0x01, 0x82, 0, 0]),
                [[1, 1, 1, 255], [2, 2, 2, 0]],
            ),
            (
                "a palette with alpha",
                png_of(ColorType::Indexed, Eight, &[1, 2, 3, 4, 5, 6], &[1, 0]),
                [[4, 5, 6, 51], [1, 2, 3, 255]],
            ),
            ("color", png_of(ColorType::Rgb, Eight, &[], &[1, 2, 3, 4, 5, 6]), [[1, 2, 3, 255], [4, 5, 6, 255]]),
        ];
        for (what, bytes, expected) in cases {
            let ([width, height], decode) = open(&bytes).unwrap();
            assert_eq!((width, height, decode().unwrap()), (2, 1, expected.to_vec()), "{what}");
            let cut = open(&bytes[..bytes.len() / 2]).and_then(|(_, decode)| decode());
            assert!(cut.is_err(), "{what}: half of it is read");
        }
    }

    #[test]
    fn photographs_of_color_and_gray_are_read() {
        let color = include_bytes!("../../../lobe-image/tests/data/color.jpg");
        let gray = include_bytes!("../../../lobe-image/tests/data/gray.jpg");
        for (what, bytes) in [("color", color.as_slice()), ("gray", gray)] {
            let (size, decode) = open(bytes).unwrap();
            let texels = decode().unwrap();
            assert_eq!((size, texels.len()), ([16, 8], 16 * 8), "{what}");
            // Red is 17 for each column, green 36 for each row, blue 128; of gray the luma is stored.
            let [r, g, b, alpha] = texels[4 * 16 + 9];
            let luma = (0.299 * 153.0 + 0.587 * 144.0 + 0.114 * 128.0_f64) as u8;
            let expected = if what == "gray" { [luma; 3] } else { [153, 144, 128] };
            let error = [r, g, b].iter().zip(expected).map(|(a, b)| a.abs_diff(b)).max();
            assert!(alpha == 255 && error <= Some(8), "{what}: {:?} for {expected:?}", texels[4 * 16 + 9]);
        }
    }

    #[test]
    fn photographs_that_are_cut_off_are_refused_with_and_without_a_mark_at_their_end() {
        let whole = include_bytes!("../../../lobe-image/tests/data/color.jpg");
        let scan = whole.windows(2).position(|pair| pair == [0xff, 0xda]).unwrap();
        // Half of the scan, and all of it without the mark of its end.
        for length in [(scan + whole.len()) / 2, whole.len() - 2] {
            let cut = &whole[..length];
            let marked = [cut, &[0xff, 0xd9]].concat();
            let found = open(cut).and_then(|(_, decode)| decode());
            assert_eq!(found, Err("a JPEG whose end is missing".to_owned()), "{length} bytes of {}", whole.len());
            let is_whole = length == whole.len() - 2;
            let found = open(&marked).and_then(|(_, decode)| decode());
            assert_eq!(found.is_ok(), is_whole, "{length} bytes of {} with a mark: {found:?}", whole.len());
        }
    }
}
