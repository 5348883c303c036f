//! RGBD: a face of a cube as an 8-bit PNG, whose alpha divides its colors.
//!
//! ```text
//!   stored   D = ⌊255 min(1/max(r, g, b), 1)⌋/255, 1/255 at least      (r D)^(1/2.2), .. , D in bytes
//!   light    r = stored^2.2 / D
//! ```
//!
//! Babylon.js keeps its environments so. Light above 255 is cut off.

use std::io::Cursor;

use png::{BitDepth, ColorType, Compression, Decoder, Encoder, Filter, Transformations};

use crate::error::ImageError;
use crate::header::decoded::{check_size, invalid};
use crate::pixel::{IntoPixel, Pixel};

/// The exponent between stored colors and light.
const GAMMA: f32 = 2.2;

/// The largest byte, for 1.
const WHITE: f32 = 255.0;

/// The most light: D is 1/255 there.
pub const RGBD_MAX: f32 = WHITE;

/// A square picture as RGBD in the bytes of a PNG file, and the number of its texels that were clamped to what RGBD
/// holds.
///
/// # Errors
/// [`ImageError::Options`] if the picture is empty or has no `size²` texels.
pub fn encode_rgbd(size: usize, texels: &[impl IntoPixel]) -> Result<(Vec<u8>, usize), ImageError> {
    let wrong = |what: String| ImageError::Options(format!("a picture as RGBD: {what}"));
    let side = u32::try_from(size).ok().filter(|side| *side > 0 && texels.len() == size * size);
    let Some(side) = side else {
        return Err(wrong(format!("{size} x {size} texels expected, {} given", texels.len())));
    };
    let mut clamped = 0;
    let mut samples = Vec::with_capacity(4 * texels.len());
    for texel in texels {
        let texel: Pixel = (*texel).into();
        clamped += usize::from(!texel.iter().all(|c| (0.0..=RGBD_MAX).contains(c)));
        samples.extend(encoded(texel));
    }
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, side, side);
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Balanced);
    encoder.set_filter(Filter::Adaptive);
    let write = || encoder.write_header()?.write_image_data(&samples);
    write().map_err(|error| wrong(error.to_string()))?;
    Ok((bytes, clamped))
}

fn encoded(texel: Pixel) -> [u8; 4] {
    let [r, g, b] = texel.map(|c| if c.is_nan() { 0.0 } else { c.clamp(0.0, RGBD_MAX) });
    let divisor = (WHITE * r.max(g).max(b).max(1.0).recip()).floor().max(1.0);
    let byte = |c: f32| (WHITE * (c * divisor / WHITE).min(1.0).powf(GAMMA.recip())).round() as u8;
    [byte(r), byte(g), byte(b), divisor as u8]
}

/// The size and the light of a square picture as RGBD from the bytes of a PNG file; `name` stands for the file in
/// messages.
///
/// # Errors
/// [`ImageError::Invalid`] if this is no PNG file, it is damaged or not square, or it has no alpha;
/// [`ImageError::Refused`] for more texels than `max_texels`.
pub fn decode_rgbd(bytes: &[u8], name: &str, max_texels: usize) -> Result<(usize, Vec<Pixel>), ImageError> {
    let damaged = |error: png::DecodingError| invalid(name, format!("damaged RGBD picture: {error}"));
    let mut decoder = Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::EXPAND | Transformations::STRIP_16);
    let mut reader = decoder.read_info().map_err(damaged)?;
    let (width, height) = (reader.info().width, reader.info().height);
    check_size(width.into(), height.into(), max_texels, name)?;
    let (color, _) = reader.output_color_type();
    if width != height || color != ColorType::Rgba {
        let text = format!("a square RGBD picture with alpha expected, found {width} x {height}, {color:?}");
        return Err(invalid(name, text));
    }
    let mut samples = vec![0; 4 * width as usize * height as usize];
    reader.next_frame(&mut samples).map_err(damaged)?;
    Ok((width as usize, samples.as_chunks::<4>().0.iter().map(decoded).collect()))
}

fn decoded([r, g, b, divisor]: &[u8; 4]) -> Pixel {
    let divisor = f32::from((*divisor).max(1)) / WHITE;
    [r, g, b].map(|c| (f32::from(*c) / WHITE).powf(GAMMA) / divisor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_comes_back_to_the_step_of_eight_bits() {
        let size = 64;
        let texel = |i: usize| {
            let level = (i as f32 / 300.0).exp2() * 0.01;
            [level, 0.5 * level, 0.03 * level]
        };
        let texels: Vec<Pixel> = (0..size * size).map(texel).collect();
        let (bytes, clamped) = encode_rgbd(size, &texels).unwrap();
        let (found_size, found) = decode_rgbd(&bytes, "test", usize::MAX).unwrap();
        assert_eq!((found_size, clamped), (size, 0), "size, texels that were clamped");
        for (found, expected) in found.iter().zip(&texels) {
            // Half a step of c D to the power of 1/2.2, at most 2.2/510 of 1, divided by D, which is rounded down.
            let divisor = (255.0 / expected[0].max(1.0)).floor() / 255.0;
            let most = 0.0044 / divisor;
            let worst = (0..3).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f32::max);
            assert!(worst < most, "{found:?}, expected {expected:?}");
        }
        let (bytes, clamped) = encode_rgbd(1, &[[300.0_f32, -1.0, f32::NAN]]).unwrap();
        let found = decode_rgbd(&bytes, "test", usize::MAX).unwrap().1;
        let is_most = (found[0][0] / RGBD_MAX - 1.0).abs() < 1e-6 && found[0][1..] == [0.0; 2];
        assert!(clamped == 1 && is_most, "beyond the range: {found:?}, {clamped} clamped");
    }

    #[test]
    fn what_is_no_square_picture_with_alpha_is_refused() {
        let error = |bytes: &[u8]| decode_rgbd(bytes, "test", 10).unwrap_err().to_string();
        assert!(error(b"no picture").contains("damaged RGBD picture"), "{}", error(b"no picture"));
        let (large, _) = encode_rgbd(4, &[[1.0_f32; 3]; 16]).unwrap();
        assert!(error(&large).contains("10"), "{}", error(&large));
        assert!(encode_rgbd(2, &[[1.0_f32; 3]; 3]).is_err(), "three texels of four");
    }
}
