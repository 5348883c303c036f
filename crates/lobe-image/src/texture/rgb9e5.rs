//! RGB9E5 texels: three colors of nine bits each and a shared exponent, in 32 bits.
//!
//! ```text
//!   bits   31..27   26..18   17..9   8..0
//!            e        b        g       r          c = m 2^(e - 15 - 9),  m = 0 .. 511,  e = 0 .. 31
//! ```
//!
//! Vulkan calls it `E5B9G9R9_UFLOAT_PACK32`, Direct3D `R9G9B9E5_SHAREDEXP`, OpenGL `RGB9_E5`.

use crate::pixel::Pixel;

/// Bits of a mantissa.
const MANTISSA_BITS: i32 = 9;

/// The bias of the stored exponent.
const BIAS: i32 = 15;

/// The largest value: `511/512 * 2^16`.
pub(crate) const MAX: f32 = 65408.0;

/// The nearest texel that can be stored, after [EXT_texture_shared_exponent].
///
/// Channels are clamped to `[0, 65408]`, NaN to 0. The exponent is the smallest with which the largest channel still
/// has a mantissa of nine bits after rounding; so the error of every channel is at most half a step, at the worst 1/511
/// of the largest if that is at least `2^-15` (test `the_error_is_at_most_half_a_step_of_the_largest_channel`).
///
/// [EXT_texture_shared_exponent]: https://registry.khronos.org/OpenGL/extensions/EXT/EXT_texture_shared_exponent.txt
pub(crate) fn encode(texel: Pixel) -> u32 {
    // f64: adding one half before the floor must not round.
    let channels = texel.map(|c| f64::from(if c > 0.0 { c.min(MAX) } else { 0.0 }));
    let largest = channels[0].max(channels[1]).max(channels[2]);
    let mut exponent = (floor_log2(largest) + 1 + BIAS).max(0);
    if largest * steps_per_unit(exponent) + 0.5 >= f64::from(1 << MANTISSA_BITS) {
        exponent += 1;
    }
    let steps = steps_per_unit(exponent);
    let [r, g, b] = channels.map(|c| (c * steps + 0.5) as u32);
    (exponent as u32) << 27 | b << 18 | g << 9 | r
}

/// The colors of a stored texel, exactly.
pub(crate) fn decode(bits: u32) -> Pixel {
    let exponent = (bits >> 27) as i32;
    let step = ((exponent - BIAS - MANTISSA_BITS) as f32).exp2();
    [bits, bits >> 9, bits >> 18].map(|m| (m & 0x1ff) as f32 * step)
}

/// `2^(15 + 9 - exponent)`, for an exponent that fits its five bits, or one more.
fn steps_per_unit(exponent: i32) -> f64 {
    f64::from_bits(((1023 + BIAS + MANTISSA_BITS - exponent) as u64) << 52)
}

/// The exponent of the highest bit of a normal number; for 0 and what is smaller, less than any stored exponent.
fn floor_log2(x: f64) -> i32 {
    (x.to_bits() >> 52) as i32 - 1023
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;

    #[test]
    fn known_texels_have_the_bits_of_the_specification() {
        // Worked by hand: 1 = 256 * 2^(16 - 24); 0.5 shares that exponent; 65408 = 511 * 2^(31 - 24).
        let cases = [
            ([0.0, 0.0, 0.0], 0),
            ([1.0, 0.5, 0.25], 16 << 27 | 64 << 18 | 128 << 9 | 256),
            ([65408.0, 128.0, 0.0], 31 << 27 | 1 << 9 | 511),
            // 511.75/512 rounds up to 512/512: the exponent grows instead.
            ([511.75 / 512.0, 0.0, 0.0], 16 << 27 | 256),
            ([1e30, f32::INFINITY, f32::NAN], 31 << 27 | 511 << 9 | 511),
            ([-1.0, f32::NEG_INFINITY, 1.0], 16 << 27 | 256 << 18),
            // The smallest step is 2^-24; half of it rounds up, less rounds to 0.
            ([2f32.powi(-24), 2f32.powi(-25), 2f32.powi(-26)], 1 << 9 | 1),
        ];
        for (texel, bits) in cases {
            let found = encode(texel);
            assert_eq!(found, bits, "{texel:?}: {found:#034b} against {bits:#034b}");
        }
    }

    #[test]
    fn every_stored_texel_with_a_full_mantissa_comes_back_with_the_same_bits() {
        for exponent in 0..32u32 {
            for m in 0..512u32 {
                // One mantissa has its highest bit set, or the exponent is the lowest: only then is the form unique.
                let bits = exponent << 27 | (256 | m) << 18 | m << 9 | (511 - m);
                let found = encode(decode(bits));
                assert_eq!(found, bits, "{bits:#x} is {:?} and comes back as {found:#x}", decode(bits));
            }
        }
    }

    #[test]
    fn the_error_is_at_most_half_a_step_of_the_largest_channel() {
        let mut random = Random::new(95);
        let mut worst = 0f64;
        for _ in 0..200_000 {
            let scale = (random.unit() * 30.0 - 14.0).exp2();
            let texel = [random.unit(), random.unit(), random.unit()].map(|c| (c * scale) as f32);
            let (a, b) = (texel, decode(encode(texel)));
            let largest = a.iter().fold(0f32, |x, c| x.max(*c));
            // Below, the steps no longer get finer.
            if largest < 2f32.powi(-15) {
                continue;
            }
            for c in 0..3 {
                worst = worst.max(f64::from((a[c] - b[c]).abs() / largest));
            }
        }
        assert!(worst <= 1.0 / 511.0 && worst > 2f64.powi(-11), "relative error {worst}");
    }
}
