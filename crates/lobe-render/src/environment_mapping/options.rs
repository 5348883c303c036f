//! Options of environment mapping: the model of reflection, and how the maps are stored.

use derive_setters::Setters;
use lobe_env::{Mapping, PrefilterOptions};

use crate::error::RenderError;
use crate::path_tracer::surfaces::Surfaces;

/// The least size of a face: each level has half of that before, and the last a texel at least.
const LEAST_SIZE: usize = 1 << (PrefilterOptions::REFLECTION_LEVELS - 1);

/// Bytes that resampling and prefiltering take at most for each texel that they start from: the texel itself and its copy, its
/// energy, its factor and four vectors of the solver; of a cube the nodes of its tree.
const BYTES_OF_TEXEL: u64 = 96;

/// Options of [`EnvironmentMaps`](crate::EnvironmentMaps).
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct EnvironmentMapOptions {
    /// The model of reflection. Default: metallic-roughness.
    pub surfaces: Surfaces,
    /// The size of the faces of the sharpest cube, from 16 on; that of roughness 1 has a sixteenth. Default: 256.
    pub size: usize,
    /// The mapping of the pictures in which reflections are looked up, interpolated between texels. Default: none, that is the
    /// texels of the light itself for mirrors, which so show what is seen behind the scene, and cubes for rough surfaces. Matte
    /// surfaces have none.
    #[setters(into)]
    pub mapping: Option<Mapping>,
    /// With a mapping: the rows of the picture for mirrors, of a cube those of a face; rougher levels have no more. Default:
    /// about as many texels as the light has.
    #[setters(into)]
    pub rows: Option<usize>,
}

impl Default for EnvironmentMapOptions {
    /// Metallic-roughness by cubes of 256 × 256 texels a face, and mirrors that show the light itself.
    fn default() -> Self {
        Self { surfaces: Surfaces::MetallicRoughness, size: 256, mapping: None, rows: None }
    }
}

impl EnvironmentMapOptions {
    /// The most bytes that making the maps of a light of `width` × `height` texels takes.
    #[must_use]
    pub fn bytes(&self, width: usize, height: usize) -> u64 {
        let squares = |count: u64, side: u64| count.saturating_mul(side).saturating_mul(side);
        let light = (width as u64).saturating_mul(height as u64);
        if self.surfaces == Surfaces::Matte {
            return light.saturating_mul(BYTES_OF_TEXEL);
        }
        // The cube that is prefiltered is twice as fine as its levels, and at most half as wide as the light is.
        let fine = self.size.checked_next_power_of_two().unwrap_or(usize::MAX) as u64;
        let cube = squares(6, fine.saturating_mul(2).min(width as u64 / 2 + 1));
        // Eight squares of texels in all levels, which take a quarter of the bytes.
        let levels = squares(2, self.size as u64);
        // No picture has more than six squares of its rows; by default it has about the texels of the light.
        let stored = match (self.mapping, self.rows) {
            (None, _) => 0,
            (Some(_), Some(rows)) => squares(6, rows as u64),
            (Some(_), None) => light.saturating_mul(2),
        };
        [light, cube, levels, stored].into_iter().fold(0, u64::saturating_add).saturating_mul(BYTES_OF_TEXEL)
    }

    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let Self { size, rows, mapping, surfaces } = *self;
        let refused = |message: &str| Err(RenderError::Options(message.to_owned()));
        if size < LEAST_SIZE {
            return Err(RenderError::Options(format!("expected faces of {LEAST_SIZE} texels or more, found {size}")));
        }
        if rows == Some(0) {
            return refused("expected a picture for reflections with rows, found 0 rows");
        }
        if mapping.is_none() && rows.is_some() {
            return refused("expected a mapping of the picture whose rows are given, found none; leave the rows out");
        }
        if mapping.is_some() && surfaces == Surfaces::Matte {
            return refused("expected surfaces that reflect a picture, found matte ones; leave its mapping out");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_that_cannot_be_are_refused() {
        let options = EnvironmentMapOptions::default();
        assert!(options.check().is_ok() && options.size(LEAST_SIZE).check().is_ok(), "the default, and the least");
        for (options, part) in [
            (options.size(15), "expected faces of 16 texels or more, found 15"),
            (options.mapping(Mapping::Cube).rows(0_usize), "found 0 rows"),
            (options.rows(8_usize), "leave the rows out"),
            (options.surfaces(Surfaces::Matte).mapping(Mapping::Cube), "leave its mapping out"),
        ] {
            let error = options.check().unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    }

    #[test]
    fn larger_maps_take_more_memory_and_none_overflows() {
        let options = EnvironmentMapOptions::default();
        let bytes = options.bytes(64, 32);
        let stored = options.mapping(Mapping::Sphere);
        let larger = [options.size(512), stored, stored.rows(99_usize)].map(|options| options.bytes(64, 32));
        for more in larger.into_iter().chain([options.bytes(128, 64)]) {
            assert!(more > bytes, "{more} and {bytes}");
        }
        assert!(options.surfaces(Surfaces::Matte).bytes(64, 32) < bytes, "matte surfaces need no levels");
        assert_eq!(options.bytes(usize::MAX / 2, usize::MAX), u64::MAX, "a map that cannot be");
    }
}
