//! RGBE texels of Radiance pictures: rounding to eight bits for each color and a shared exponent.

use crate::pixel::{BLACK, Pixel};

/// Added to a mantissa so that a truncating encoder arrives at it, whatever its rounding errors.
const SAFETY: f64 = 0.25;

/// A texel that a truncating encoder stores as the nearest one of the format.
///
/// Truncation makes every channel darker by half a step on average, 0.2 to 0.4 % of the largest channel, and so the sum
/// over a map. Rounding to nearest has no such bias, if ties go to even: an eighth of the values of a `half` picture
/// are ties (test `a_real_map_has_the_same_harmonics_through_every_format`). Channels must be finite and not negative.
pub(crate) fn rounded(texel: Pixel) -> Pixel {
    let channels = texel.map(f64::from);
    let largest = channels[0].max(channels[1]).max(channels[2]);
    if largest <= 0.0 {
        return BLACK;
    }
    // 2^(k - 8) is the step of a largest channel below 2^k; if that rounds up to 256 steps, the step doubles.
    let mut step = (largest.log2().floor() + 1.0 - 8.0).exp2();
    if (largest / step).round_ties_even() >= 256.0 {
        step *= 2.0;
    }
    channels.map(|c| (((c / step).round_ties_even() + SAFETY) * step) as f32)
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;

    #[test]
    fn cutting_off_what_was_rounded_leaves_the_nearest() {
        let mut random = Random::new(8);
        let (mut worst, mut sum) = (0f64, 0f64);
        for _ in 0..100_000 {
            let scale = (40.0 * random.signed()).exp2();
            let texel = [random.unit(), random.unit(), random.unit()].map(|c| (c * scale) as f32);
            let largest = texel.into_iter().fold(0.0, f32::max);
            let prepared = rounded(texel);
            let step = (prepared.into_iter().fold(0.0, f32::max).log2().floor() + 1.0 - 8.0).exp2();
            for (c, p) in texel.into_iter().zip(prepared) {
                let error = f64::from((p / step).floor() * step - c) / f64::from(largest);
                worst = worst.max(error.abs());
                sum += error;
            }
        }
        // Half a step of a largest channel that rounds up to 128 steps; the mean of 300000 errors with both signs.
        assert!(worst <= 0.5 / 127.5, "largest error {worst}");
        assert!((sum / 300_000.0).abs() < 2e-5, "mean error {}", sum / 300_000.0);
    }

    #[test]
    fn black_stays_black() {
        assert_eq!(rounded(BLACK), BLACK, "black");
    }
}
