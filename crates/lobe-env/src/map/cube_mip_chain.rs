//! Mip chains of cube maps.

use lobe_image::{mip_level_count, mip_level_size};

use crate::error::EnvError;
use crate::map::cube_average::averaged_to;
use crate::map::cube_map::CubeMap;

/// A cube map with its mip levels: level `k` has faces of `max(1, size >> k)` texels.
///
/// The meaning of the levels is the caller's: [`CubeMipChain::averaged`] makes area averages, a prefiltered map holds
/// one roughness in each level. There may be any number of levels from one to the full chain, whose last has a size of
/// 1.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeMipChain {
    levels: Vec<CubeMap>,
}

impl CubeMipChain {
    /// A chain from its levels, the largest first.
    ///
    /// # Errors
    /// [`EnvError::Options`] if there is no level, or one whose size is not half of that before, rounded down.
    pub fn new(levels: Vec<CubeMap>) -> Result<Self, EnvError> {
        let Some(first) = levels.first() else {
            return Err(EnvError::Options("a chain of cube maps needs at least one level".into()));
        };
        let most = mip_level_count(first.size());
        if levels.len() > most {
            let message =
                format!("a cube map of size {} has at most {most} levels, not {}", first.size(), levels.len());
            return Err(EnvError::Options(message));
        }
        let expected = |k: usize| mip_level_size(first.size(), k);
        if let Some((k, level)) = levels.iter().enumerate().find(|(k, level)| level.size() != expected(*k)) {
            let message = format!("level {k} must have a size of {}, not {}", expected(k), level.size());
            return Err(EnvError::Options(message));
        }
        Ok(Self { levels })
    }

    /// The chain of one level.
    #[must_use]
    pub fn single(map: CubeMap) -> Self {
        Self { levels: vec![map] }
    }

    /// The full chain down to a size of 1, each texel the mean of the texels it covers in the level before.
    ///
    /// Texels are weighted with solid angles, those that are cut with that of each part, so the mean over the sphere is
    /// the same in every level.
    #[must_use]
    pub fn averaged(map: CubeMap) -> Self {
        let mut levels = vec![map];
        while let Some(last) = levels.last()
            && last.size() > 1
        {
            levels.push(averaged_to(last, last.size() / 2));
        }
        Self { levels }
    }

    /// The levels, the largest first; at least one.
    #[must_use]
    pub fn levels(&self) -> &[CubeMap] {
        &self.levels
    }

    /// The levels, to change their texels.
    pub(crate) fn levels_mut(&mut self) -> &mut [CubeMap] {
        &mut self.levels
    }

    /// The largest level.
    #[must_use]
    pub fn base(&self) -> &CubeMap {
        &self.levels[0]
    }

    /// The largest level, without the others.
    #[must_use]
    pub fn into_base(mut self) -> CubeMap {
        self.levels.swap_remove(0)
    }
}

#[cfg(test)]
mod tests {
    use lobe_sh::Rgb;

    use super::*;

    fn map(size: usize) -> CubeMap {
        CubeMap::from_fn(size, |s| Rgb::new(2.0 + s.x() as f32, 1.5 + s.y() as f32, (4.0 * s.z() as f32).exp()))
    }

    #[test]
    fn the_mean_stays_the_same_in_every_level() {
        // Texels are f32: each level may lose 2^-24 of it.
        let tolerance = 1e-6;
        for size in [64, 16, 1, 63, 24, 37, 5, 3] {
            let chain = CubeMipChain::averaged(map(size));
            let mean = chain.base().mean();
            assert_eq!(chain.levels().len(), mip_level_count(size), "levels of {size}");
            for level in chain.levels() {
                let error = (level.mean().b / mean.b - 1.0).abs().max((level.mean().r / mean.r - 1.0).abs());
                assert!(error < tolerance, "{size} to {}: {:?} against {mean:?}", level.size(), level.mean());
            }
        }
    }

    #[test]
    fn wrong_chains_are_refused() {
        let refused =
            |sizes: &[usize]| CubeMipChain::new(sizes.iter().map(|s| map(*s)).collect()).unwrap_err().to_string();
        assert!(refused(&[]).contains("at least one"), "no level: {}", refused(&[]));
        assert!(refused(&[4, 3]).contains("size of 2, not 3"), "wrong size: {}", refused(&[4, 3]));
        assert!(refused(&[2, 1, 1]).contains("at most 2"), "too many: {}", refused(&[2, 1, 1]));
        let sizes: Vec<_> =
            CubeMipChain::new([9, 4, 2].map(map).into()).unwrap().levels().iter().map(CubeMap::size).collect();
        assert_eq!(sizes, [9, 4, 2], "a part of a chain");
    }
}
