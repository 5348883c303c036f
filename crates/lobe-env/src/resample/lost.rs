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
    /// The sum of the squares of what it lacks of each texel, over the channels' sum.
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
            self.squares += (missing.r + missing.g + missing.b).powi(2);
        }
    }

    /// Whether no texel lacks much, and the mean of no channel more than can be given to all texels.
    pub(crate) fn is_little(&self) -> bool {
        let Rgb { r, g, b } = self.uniform;
        let of_mean = |c: usize| {
            let (total, uniform, missing) = self.of_channel(c);
            missing.abs() <= (UNSCALED_TOLERANCE * uniform).max(MOST_SCALED * uniform.min(total.abs()))
        };
        self.squares.sqrt() <= TEXELS_TOLERANCE * (r + g + b) && (0..3).all(of_mean)
    }

    /// The factors `b`, which keep the mean; as near to them as may be where too much is missing.
    pub(crate) fn factor(&self) -> Rgb<f32> {
        Rgb::from_channels(|c| {
            let (total, uniform, missing) = self.of_channel(c);
            let is_kept = missing.abs() <= UNSCALED_TOLERANCE * uniform;
            let share = if is_kept { 0.0 } else { (missing / total).clamp(-MOST_SCALED, MOST_SCALED) };
            (1.0 / (1.0 - share)) as f32
        })
    }

    /// All light, the uniform light and what is missing of it.
    fn of_channel(&self, c: usize) -> (f64, f64, f64) {
        (self.total.channel(c), self.uniform.channel(c), self.missing.channel(c))
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
