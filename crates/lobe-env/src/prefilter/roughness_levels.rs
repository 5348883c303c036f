//! Roughness of the levels of prefiltered chains, by the lookups of engines.

use std::fmt;
use std::str::FromStr;

use crate::error::EnvError;

/// Smaller faces than these hold a rough reflection badly: their texels are wider than its changes.
pub(crate) const LAST_SIZE: usize = 16;

/// Levels of Babylon.js for each doubling of α: its `lodGenerationScale`.
pub(crate) const BABYLON_SCALE: f64 = 0.8;

/// The level that Unity reads for roughness 1, whatever the size: its `UNITY_SPECCUBE_LOD_STEPS`.
const UNITY_STEPS: f64 = 6.0;

/// Unreal's levels for each halving of the roughness: its `REFLECTION_CAPTURE_ROUGHNESS_MIP_SCALE`.
const UNREAL_SCALE: f64 = 1.2;

/// Levels of Unreal behind the one that holds roughness 1.
const UNREAL_SPARE: f64 = 2.0;

/// The roughness of each level of a prefiltered chain; `n` is the number of the last level, 0 that of the first.
///
/// ```text
///   Linear      level = n ρ
///   Quadratic   level = n ρ (2 - ρ)
///   Babylon     level = 0.8 (n + log₂ α)         faces of 2ⁿ texels, down to one
///   Unity       level = 6 ρ (1.7 - 0.7 ρ)        the chain has seven levels or more
///   Unreal      level = n - 2 + 1.2 log₂ ρ       down to one texel
/// ```
///
/// Roughness here is perceptual, `ρ = √α` in `[0, 1]`. Level 0 is the mirror, though Babylon and Unreal read small
/// roughness there too; levels behind that of `ρ = 1` hold `ρ = 1`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum RoughnessLevels {
    /// `ρ = level/n`: the glTF sample viewer, bevy, `EXT_lights_image_based`.
    #[default]
    Linear,
    /// More levels for smooth surfaces, whose reflections change most: Filament and three.js.
    Quadratic,
    /// Babylon.js: each level has 2.4 times the α of the one before.
    Babylon,
    /// Unity.
    Unity,
    /// Unreal Engine.
    Unreal,
}

impl RoughnessLevels {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Linear, Self::Quadratic, Self::Babylon, Self::Unity, Self::Unreal];

    /// The name in options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Quadratic => "quadratic",
            Self::Babylon => "babylon",
            Self::Unity => "unity",
            Self::Unreal => "unreal",
        }
    }

    /// The fewest levels of a chain, where `full` is the number of those down to one texel.
    pub(crate) fn least_levels(self, full: usize) -> usize {
        match self {
            Self::Linear | Self::Quadratic => 1,
            Self::Unity => UNITY_STEPS as usize + 1,
            // Engines take the number of levels from the size of the faces.
            Self::Babylon | Self::Unreal => full,
        }
    }

    /// The size of the last level where none is given: 16, or 1 for engines that read levels down to one texel.
    #[must_use]
    pub fn usual_last_size(self, size: usize) -> usize {
        match self {
            Self::Linear | Self::Quadratic => LAST_SIZE.min(size),
            Self::Babylon | Self::Unity | Self::Unreal => 1,
        }
    }

    /// The roughness of `level` of `levels`; 0 of the first.
    ///
    /// # Panics
    /// If there is no such level.
    #[must_use]
    pub fn roughness_of_level(self, level: usize, levels: usize) -> f64 {
        assert!(level < levels, "no level {level} in a chain of {levels}");
        if level == 0 {
            return 0.0;
        }
        let (k, n) = (level as f64, (levels - 1) as f64);
        let roughness = match self {
            Self::Linear => k / n,
            Self::Quadratic => 1.0 - (1.0 - k / n).sqrt(),
            Self::Babylon => (k / BABYLON_SCALE - n).exp2().sqrt(),
            // The smaller root of 0.7 ρ² - 1.7 ρ + level/6.
            Self::Unity => (1.7 - (1.7_f64.powi(2) - 2.8 * (k / UNITY_STEPS).min(1.0)).sqrt()) / 1.4,
            Self::Unreal => ((k - n + UNREAL_SPARE) / UNREAL_SCALE).exp2(),
        };
        roughness.min(1.0)
    }

    /// The level, or fraction between levels, of a roughness, which is clamped to `[0, 1]`.
    #[must_use]
    pub fn level_for_roughness(self, roughness: f64, levels: usize) -> f64 {
        let r = roughness.clamp(0.0, 1.0);
        let n = levels.saturating_sub(1) as f64;
        let level = match self {
            Self::Linear => n * r,
            Self::Quadratic => n * r * (2.0 - r),
            Self::Babylon => BABYLON_SCALE * (n + 2.0 * r.log2()),
            Self::Unity => UNITY_STEPS * r * (1.7 - 0.7 * r),
            Self::Unreal => n - UNREAL_SPARE + UNREAL_SCALE * r.log2(),
        };
        level.clamp(0.0, n)
    }
}

impl fmt::Display for RoughnessLevels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for RoughnessLevels {
    type Err = EnvError;

    fn from_str(text: &str) -> Result<Self, EnvError> {
        Self::ALL.into_iter().find(|levels| levels.name() == text).ok_or_else(|| {
            let names = Self::ALL.map(Self::name);
            EnvError::Options(format!("expected {}, found {text:?}", lobe_io::either(&names)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_is_found_again_by_its_roughness() {
        for mapping in RoughnessLevels::ALL {
            for levels in mapping.least_levels(4).max(2)..14 {
                let roughness = |k| mapping.roughness_of_level(k, levels);
                assert_eq!(roughness(0), 0.0, "{mapping}: the mirror of {levels}");
                for k in 1..levels {
                    let (r, found) = (roughness(k), mapping.level_for_roughness(roughness(k), levels));
                    let is_rough = r == 1.0 && found <= k as f64;
                    assert!((found - k as f64).abs() < 1e-12 || is_rough, "{mapping}, {k} of {levels}: {r}, {found}");
                    assert!(r >= roughness(k - 1), "{mapping}, {k} of {levels}: {r} is smoother than before");
                }
            }
        }
    }

    #[test]
    fn the_roughest_surface_reads_a_level_of_roughness_one() {
        for mapping in RoughnessLevels::ALL {
            for levels in mapping.least_levels(4).max(2)..14 {
                let level = mapping.level_for_roughness(1.0, levels);
                let [below, above] =
                    [level.floor(), level.ceil()].map(|k| mapping.roughness_of_level(k as usize, levels));
                assert_eq!(above, 1.0, "{mapping}, of {levels}: level {level} lies between {below} and {above}");
            }
        }
    }

    #[test]
    fn levels_are_those_that_the_engines_read() {
        // Seen in Babylon.js with faces of 64 texels, in Filament with six levels.
        for (mapping, levels, expected) in [
            (RoughnessLevels::Babylon, 7, [1.6, 3.2, 4.1359]),
            (RoughnessLevels::Quadratic, 6, [2.1875, 3.75, 4.6875]),
            (RoughnessLevels::Linear, 6, [1.25, 2.5, 3.75]),
            (RoughnessLevels::Unity, 8, [2.2875, 4.05, 5.2875]),
            (RoughnessLevels::Unreal, 8, [2.6, 3.8, 4.5020]),
        ] {
            for (roughness, expected) in [0.25, 0.5, 0.75].into_iter().zip(expected) {
                let found = mapping.level_for_roughness(roughness, levels);
                assert!((found - expected).abs() < 1e-4, "{mapping}, {roughness}: {found}, expected {expected}");
            }
        }
    }

    #[test]
    fn a_mapping_is_read_by_the_name_that_it_prints() {
        for mapping in RoughnessLevels::ALL {
            assert_eq!(mapping.to_string().parse::<RoughnessLevels>().unwrap(), mapping, "{mapping}");
        }
        let error = "cubic".parse::<RoughnessLevels>().unwrap_err().to_string();
        assert!(error.starts_with("expected linear, quadratic") && error.ends_with("found \"cubic\""), "{error}");
    }
}
