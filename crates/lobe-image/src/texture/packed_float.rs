//! R11G11B10F texels: three floats without sign, of 11, 11 and 10 bits.

use half::f16;

use crate::pixel::Pixel;

/// The largest value that all three channels hold: that of ten bits, a mantissa of five and the exponent 15.
pub(crate) const MAX: f32 = 64512.0;

/// The bits that a `half` without its sign has more than each channel.
const DROPPED: [u32; 3] = [4, 4, 5];

/// Where the bits of each channel begin.
const SHIFTS: [u32; 3] = [0, 11, 22];

/// The texel nearest to one whose channels are in `[0, MAX]`; six, six and five bits of mantissa, so that the error is below
/// 0.8 % in red and green and 1.6 % in blue.
pub(crate) fn encode(texel: Pixel) -> u32 {
    let channel = |c: usize| {
        let (bits, dropped) = (u32::from(f16::from_f32(texel[c]).to_bits() & 0x7fff), DROPPED[c]);
        // To the nearest, ties to even. A negative zero is zero.
        let rounded = (bits + (1 << (dropped - 1)) - 1 + (bits >> dropped & 1)) >> dropped;
        rounded << SHIFTS[c]
    };
    channel(0) | channel(1) | channel(2)
}

/// The colors of a stored texel, exactly.
pub(crate) fn decode(bits: u32) -> Pixel {
    [0, 1, 2].map(|c| {
        let width = 15 - DROPPED[c];
        f16::from_bits(((bits >> SHIFTS[c] & ((1 << width) - 1)) << DROPPED[c]) as u16).to_f32()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_zero_is_black() {
        assert_eq!(encode([-0.0; 3]), 0, "no sign reaches another channel");
    }

    #[test]
    fn known_texels_have_the_bits_of_the_format() {
        // 1 is the exponent 15 and no mantissa; 1.5 has the highest bit of the mantissa.
        assert_eq!(encode([1.0, 1.5, 0.0]), 15 << 6 | (15 << 6 | 32) << 11, "one and a half");
        assert_eq!(encode([0.0, 0.0, 1.0]), 15 << 5 << 22, "blue");
        assert_eq!(encode([65024.0, 65024.0, MAX]), !(1 << 6 | 1 << 17 | 1 << 27), "the largest");
    }

    #[test]
    fn every_finite_channel_comes_back_with_the_same_bits() {
        for bits in (0..0x7c0_u32).chain((0..0x7c0).map(|b| b << 11)).chain((0..0x3e0).map(|b| b << 22)) {
            let found = encode(decode(bits));
            assert_eq!(found, bits, "{bits:#x} is {:?} and comes back as {found:#x}", decode(bits));
        }
    }

    #[test]
    fn the_error_is_half_a_step() {
        for k in 0..1000 {
            let value = (0.02 * k as f32 - 10.0).exp2();
            for (found, limit) in decode(encode([value; 3])).into_iter().zip([1.0 / 128.0, 1.0 / 128.0, 1.0 / 64.0]) {
                assert!((found / value - 1.0).abs() <= limit, "{value} became {found}");
            }
        }
    }
}
