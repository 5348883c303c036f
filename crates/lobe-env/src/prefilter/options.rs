//! Options of prefiltering: the sizes of the chain, the roughness of its levels, and how exact they are.

use derive_setters::Setters;
use lobe_image::{mip_level_count, mip_level_size};

use crate::error::EnvError;
use crate::map::cube_map::CubeMap;
use crate::prefilter::roughness_levels::{LAST_SIZE, RoughnessLevels};

/// The least tolerance: below, errors of single precision dominate.
const LEAST_TOLERANCE: f64 = 1e-6;

/// The largest tolerance.
const LARGEST_TOLERANCE: f64 = 0.1;

/// Options of prefiltering.
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct PrefilterOptions {
    /// The size of the faces of level 0. Default: 256.
    pub size: usize,
    /// The chain ends with the last level that is not smaller than this. Default: 16.
    pub last_size: usize,
    /// The roughness of each level. Default: linear.
    pub roughness: RoughnessLevels,
    /// The error that is allowed, relative to the peak that a single small light makes; in `[1e-6, 0.1]`. Default: 0.02.
    ///
    /// The light is integrated by hierarchical quadrature over all of the source, in cells as large as the lobe allows.
    /// Wherever the lobe is replaced by a polynomial, its error is at most `tolerance (K + √(K_peak K_mean)/b)`, except
    /// at a kink. `b` is 1 up to sixteen times the median of the map's brightness, and at least half of the brightness
    /// beyond, up to 2²⁰ times the median: the error of a lamp must not show in the dark. For a source of one small
    /// light the error is below that; for light everywhere far below, because the polynomials' errors cancel.
    ///
    /// Measured at the default, with suns of one and two texels over a sky and α from 1/16 to 1: below 3e-3 of the
    /// brightest texel (test `filtered_maps_against_brute_force_and_samples`); with lamps 10⁵ times as bright as most
    /// of the map, below 3e-3 of a texel's own value, the darkest texels among those looked at (test
    /// `lamps_do_not_spoil_the_dark`).
    pub tolerance: f64,
}

impl Default for PrefilterOptions {
    fn default() -> Self {
        Self { size: 256, last_size: LAST_SIZE, roughness: RoughnessLevels::default(), tolerance: 0.02 }
    }
}

impl PrefilterOptions {
    /// Levels of [`PrefilterOptions::of_reflections`], the mirror among them.
    pub const REFLECTION_LEVELS: usize = 5;

    /// The chain in which shiny surfaces look their light up, of faces of this size: of roughness 0, 0.13, 0.29, 0.5
    /// and 1.
    #[must_use]
    pub fn of_reflections(size: usize) -> Self {
        let last_size = (size >> (Self::REFLECTION_LEVELS - 1)).max(1);
        Self { size, last_size, roughness: RoughnessLevels::Quadratic, ..Self::default() }
    }

    /// The number of levels.
    #[must_use]
    pub fn levels(&self) -> usize {
        (0..mip_level_count(self.size))
            .take_while(|k| *k == 0 || mip_level_size(self.size, *k) >= self.last_size)
            .count()
    }

    /// The GGX width `α = ρ²` of a level.
    ///
    /// # Panics
    /// If there is no such level.
    #[must_use]
    pub fn alpha_of_level(&self, level: usize) -> f64 {
        self.roughness.roughness_of_level(level, self.levels()).powi(2)
    }

    pub(crate) fn check(&self) -> Result<(), EnvError> {
        if self.size == 0 || self.last_size == 0 || self.last_size > self.size {
            let (size, last) = (self.size, self.last_size);
            return Err(EnvError::Options(format!(
                "a chain goes down from its size to 1 at least, not {size} to {last}"
            )));
        }
        CubeMap::check_size(self.size)?;
        let (levels, least) = (self.levels(), self.roughness.least_levels(mip_level_count(self.size)));
        if levels < least {
            let (roughness, size, last) = (self.roughness, self.size, self.last_size);
            return Err(EnvError::Options(format!(
                "the roughness of {roughness} takes {least} levels, but there are {levels} from {size} to {last}"
            )));
        }
        check_tolerance(self.tolerance)
    }
}

pub(crate) fn check_tolerance(tolerance: f64) -> Result<(), EnvError> {
    if (LEAST_TOLERANCE..=LARGEST_TOLERANCE).contains(&tolerance) {
        return Ok(());
    }
    let range = format!("[{LEAST_TOLERANCE}, {LARGEST_TOLERANCE}]");
    Err(EnvError::Options(format!("the tolerance of a filter lies in {range}, not {tolerance}")))
}
