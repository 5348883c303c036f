//! RGBD: a face of a cube as an 8-bit PNG, whose alpha divides its colors.
//!
//! ```text
//!   stored   D = ⌊255 min(1/max(r, g, b), 1)⌋/255, 1/255 at least      (r D)^(1/2.2), .. , D in bytes
//!   light    r = stored^2.2 / D
//! ```
//!
//! Babylon.js keeps its environments so. Light above 255 is cut off.

use png::{BitDepth, ColorType, Compression, Encoder, Filter};

use crate::error::ImageError;
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The width and the light of a picture.
    fn decode_rgbd(bytes: &[u8]) -> (usize, Vec<Pixel>) {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut samples = vec![0; reader.output_buffer_size().unwrap()];
        let size = reader.next_frame(&mut samples).unwrap().width as usize;
        let decoded = |[r, g, b, divisor]: &[u8; 4]| {
            [r, g, b].map(|c| (f32::from(*c) / WHITE).powf(GAMMA) * WHITE / f32::from(*divisor))
        };
        (size, samples.as_chunks::<4>().0.iter().map(decoded).collect())
    }

    #[test]
    fn light_comes_back_to_the_step_of_eight_bits() {
        let size = 64;
        let texel = |i: usize| {
            let level = (i as f32 / 300.0).exp2() * 0.01;
            [level, 0.5 * level, 0.03 * level]
        };
        let texels: Vec<Pixel> = (0..size * size).map(texel).collect();
        let (bytes, clamped) = encode_rgbd(size, &texels).unwrap();
        let (found_size, found) = decode_rgbd(&bytes);
        assert_eq!((found_size, clamped), (size, 0), "size, texels that were clamped");
        for (found, expected) in found.iter().zip(&texels) {
            // Half a step of c D to the power of 1/2.2, at most 2.2/510 of 1, divided by D, which is rounded down.
            let divisor = (255.0 / expected[0].max(1.0)).floor() / 255.0;
            let most = 0.0044 / divisor;
            let worst = (0..3).map(|c| (found[c] - expected[c]).abs()).max_by(f32::total_cmp).unwrap();
            assert!(worst < most, "{found:?}, expected {expected:?}");
        }
        let (bytes, clamped) = encode_rgbd(1, &[[300.0_f32, -1.0, f32::NAN]]).unwrap();
        let found = decode_rgbd(&bytes).1;
        let is_most = (found[0][0] / RGBD_MAX - 1.0).abs() < 1e-6 && found[0][1..] == [0.0; 2];
        assert!(clamped == 1 && is_most, "beyond the range: {found:?}, {clamped} clamped");
    }

    #[test]
    fn texels_that_are_no_square_are_refused() {
        let error = encode_rgbd(2, &[[1.0_f32; 3]; 3]).unwrap_err().to_string();
        assert!(error.contains("2 x 2 texels expected, 3 given"), "{error}");
    }
}
