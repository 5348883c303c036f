//! Options of exporting a light for engines.

use derive_setters::Setters;

use crate::error::EnvError;
use crate::prefilter::options::PrefilterOptions;
use crate::sky::sun_choice::SunChoice;

/// The least size of faces: three.js ends its chains at 8 texels.
const LEAST_SIZE: usize = 16;

/// Options of exporting a light.
#[derive(Clone, Debug, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct ExportOptions {
    /// The size of the faces of cubes, a power of two, 16 or more. Default: 256.
    pub size: usize,
    /// Which suns are lights of their own; programs that trace paths keep those of the map in it. Default: auto.
    pub suns: SunChoice,
    /// The tolerance of prefiltering, see [`PrefilterOptions::tolerance`]. Default: 0.02.
    pub tolerance: f64,
}

impl Default for ExportOptions {
    fn default() -> Self {
        let PrefilterOptions { size, tolerance, .. } = PrefilterOptions::default();
        Self { size, suns: SunChoice::default(), tolerance }
    }
}

impl ExportOptions {
    /// Refuses options with which nothing can be exported.
    ///
    /// # Errors
    /// [`EnvError::Options`] for a size that is no power of two, or too small.
    pub fn check(&self) -> Result<(), EnvError> {
        if self.size < LEAST_SIZE || !self.size.is_power_of_two() {
            let text =
                format!("faces for engines have a power of two of texels, {LEAST_SIZE} or more, not {}", self.size);
            return Err(EnvError::Options(text));
        }
        Ok(())
    }
}
