//! Light that a resampled map lacks when its weights are balanced, and the factor that gives it back.
//!
//! ```text
//!   b = Σ Ω_s L_s / (Σ Ω_s L_s - Σ (Ω_s - E_s) min(L_s, m_s))        per channel, over the texels of the source
//! ```

use lobe_sh::{Coefficient, Rgb};

// E_s is the energy that source texel s, of solid angle Ω_s, has in the target; m_s is the mean of its neighbors. Of
// light that exceeds them nothing is lost (see `balance`).
//
// To give a little to all texels keeps constants, of which nothing is lacking, and spares the many passes that a sun of
// many texels would need, which holds half of all light and exceeds no neighbor. It may lose that little to the sky.
//
// Light that is not finite has no energy to keep: its texels are left out.

/// What the mean of a channel may lack, relative to that of its magnitude, with nothing given to all texels: constants
/// keep their bits.
const UNSCALED_TOLERANCE: f64 = 5e-6;
/// The most that is given to all texels, relative to the mean and to that of the uniform light: a quarter of a step of
/// eight bits.
const MOST_SCALED: f64 = 1e-3;
/// What the texels lack, as the root of the sum of squares, relative to the uniform light: were their signs random, the
/// mean would be off by this, and a large part of the surroundings by little more.
const TEXELS_TOLERANCE: f64 = 1e-4;

/// What the target lacks of the light of the source: sums over the texels whose light is finite.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lost {
    /// All light, `Σ Ω L`.
    total: Rgb<f64>,
    /// What is no excess over neighbors, `Σ Ω |min(L, m)|`: by magnitude, as the mean of light of both signs may be
    /// nothing.
    uniform: Rgb<f64>,
    /// What the target lacks of it, `Σ (Ω - E) min(L, m)`; below 0 where it has too much.
    missing: Rgb<f64>,
    /// The sum over the texels of the squares of what it lacks of all channels, by magnitude.
    squares: f64,
}

impl Lost {
    /// Adds a texel that has light, the part of it that is no excess, a solid angle, and lacks `missing` of that.
    pub(crate) fn add(&mut self, light: Rgb<f64>, uniform: Rgb<f64>, solid_angle: f64, missing: f64) {
        if light.to_array().into_iter().chain(uniform.to_array()).all(f64::is_finite) {
            let missing = uniform.scale(missing);
            self.total += light.scale(solid_angle);
            self.uniform += Rgb::from(uniform.to_array().map(f64::abs)).scale(solid_angle);
            self.missing += missing;
            self.squares += (missing.r.abs() + missing.g.abs() + missing.b.abs()).powi(2);
        }
    }

    /// Whether no texel lacks much, and the mean of no channel more than can be given to all texels.
    pub(crate) fn is_little(&self) -> bool {
        let Rgb { r, g, b } = self.uniform;
        let of_mean = |c: usize| {
            let missing = self.missing.channel(c).abs();
            missing <= self.least_scaled(c).max(self.most_scaled(c))
        };
        self.squares.sqrt() <= TEXELS_TOLERANCE * (r + g + b) && (0..3).all(of_mean)
    }

    /// The factors `b`, which keep the mean; as near to them as may be where too much is missing. 1 where little is
    /// missing, and where the mean is so near to 0 that little can be given.
    pub(crate) fn factor(&self) -> Rgb<f32> {
        Rgb::from_channels(|c| {
            let (missing, most) = (self.missing.channel(c), self.most_scaled(c));
            if missing.abs().min(most) <= self.least_scaled(c) {
                return 1.0;
            }
            (1.0 / (1.0 - missing.clamp(-most, most) / self.total.channel(c))) as f32
        })
    }

    /// What may be missing of channel `c` with nothing given to all texels.
    fn least_scaled(&self, c: usize) -> f64 {
        UNSCALED_TOLERANCE * self.uniform.channel(c)
    }

    /// The most of channel `c` that is given to all texels.
    fn most_scaled(&self, c: usize) -> f64 {
        MOST_SCALED * self.uniform.channel(c).min(self.total.channel(c).abs())
    }
}

impl std::ops::Add for Lost {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            total: self.total + other.total,
            uniform: self.uniform + other.uniform,
            missing: self.missing + other.missing,
            squares: self.squares + other.squares,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sums of two texels of solid angle 1, each with its uniform light, of which one lacks a part.
    fn lost(lights: [f64; 2], missing: f64) -> Lost {
        let mut sums = Lost::default();
        for (light, missing) in lights.into_iter().zip([missing, 0.0]) {
            sums.add(Rgb::splat(light), Rgb::splat(light), 1.0, missing);
        }
        sums
    }

    #[test]
    fn the_factor_gives_back_what_is_missing_up_to_a_thousandth_and_nothing_to_a_mean_of_zero() {
        let factor = |lights, missing| f64::from(lost(lights, missing).factor().g);
        assert_eq!(factor([1.0, 1.0], 9e-6), 1.0, "less than the tolerance is missing");
        assert!((factor([1.0, 1.0], 1e-3) - 2.0 / 1.999).abs() < 1e-7, "the mean is kept");
        assert!((factor([1.0, 1.0], 0.5) - 1.0 / 0.999).abs() < 1e-7, "no more than the most is given");
        assert!((factor([1.0, 1.0], -0.5) - 1.0 / 1.001).abs() < 1e-7, "nor taken");
        for missing in [1e-5, 0.1, -0.1] {
            assert_eq!(factor([1.0, -1.0], missing), 1.0, "a mean of zero has nothing to give");
        }
    }

    #[test]
    fn texels_that_are_not_finite_are_left_out() {
        let mut sums = lost([1.0, 1.0], 1e-3);
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            sums.add(Rgb::new(1.0, value, 1.0), Rgb::splat(1.0), 1.0, 0.5);
        }
        assert_eq!(sums.factor(), lost([1.0, 1.0], 1e-3).factor(), "factors with and without them");
    }

    #[test]
    fn deficits_of_channels_of_opposite_sign_do_not_cancel() {
        let mut sums = Lost::default();
        for missing in [0.1, -0.1] {
            let light = Rgb::new(1.0, -1.0, 0.0);
            sums.add(light, light, 1.0, missing);
        }
        assert!(!sums.is_little(), "a tenth of each texel is no little");
    }
}
