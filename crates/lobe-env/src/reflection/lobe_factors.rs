//! Factors of the bands of an expansion under lobes of microfacets.

use lobe_sh::Zonal;

/// Factors by which the lobe of GGX about its axis, seen along the normal, blurs each band of an expansion, between
/// levels of roughness that are evenly spaced.
///
/// ```text
///   (k ∗ f)ᵢ = k_l(α) fᵢ       α = roughness²       k_l = √(4π/(2l+1)) z_l of [`Zonal::ggx`]
/// ```
///
/// What a point sees under a lobe is a ratio of two expansions so blurred; two limits keep that from dividing small
/// numbers.
///
/// ```
/// use lobe_env::LobeFactors;
///
/// let factors = LobeFactors::new(4);
/// assert_eq!(factors.at(0.0)[3].round(), 1.0, "a mirror blurs nothing");
/// assert!((factors.at(1.0)[1] - 2.0 / 3.0).abs() < 1e-3, "roughness 1 is the clamped cosine");
/// ```
#[derive(Clone, Debug)]
pub struct LobeFactors {
    levels: Vec<Vec<f64>>,
}

impl LobeFactors {
    /// Levels of roughness, from 0 to 1.
    pub const LEVELS: usize = 17;

    /// Below this mean of the cosine under a lobe, times π, what the lobe meets is taken for what the hemisphere does:
    /// that much of it is below the horizon.
    pub const LEAST_ABOVE: f64 = 0.05;

    /// Below this hidden part of the hemisphere, the radiance of what hides it, a ratio of two small numbers, is that
    /// of so large a part.
    pub const LEAST_HIDDEN: f64 = 0.02;

    /// The factors of this many bands.
    #[must_use]
    pub fn new(order: usize) -> Self {
        let level = |k: usize| {
            let roughness = k as f64 / (Self::LEVELS - 1) as f64;
            Zonal::ggx(order, roughness * roughness).convolution_factors()
        };
        Self { levels: (0..Self::LEVELS).map(level).collect() }
    }

    /// The factors of each level.
    #[must_use]
    pub fn levels(&self) -> &[Vec<f64>] {
        &self.levels
    }

    /// The factors at a roughness in `[0, 1]`, between two levels.
    #[must_use]
    pub fn at(&self, roughness: f64) -> Vec<f64> {
        let place = roughness.clamp(0.0, 1.0) * (Self::LEVELS - 1) as f64;
        let low = (place as usize).min(Self::LEVELS - 2);
        let t = place - low as f64;
        self.levels[low].iter().zip(&self.levels[low + 1]).map(|(a, b)| a + (b - a) * t).collect()
    }
}
