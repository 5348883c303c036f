//! A cube map with its smaller versions.

use lobe_sh::{Coefficient, Rgb};
use rayon::prelude::*;

use crate::cube::{self, FACES};
use crate::{CubeMap, EnvError};

/// A cube map in falling sizes: level `k` has faces of `max(1, size >> k)` texels.
///
/// What the levels mean is the caller's business: [`CubeMipChain::averaged`] makes smaller and smaller means, a
/// prefiltered map holds one roughness in each level. There may be any number of levels from one to the last, which
/// has a size of 1.
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
        let most = level_count(first.size());
        if levels.len() > most {
            let message =
                format!("a cube map of size {} has at most {most} levels, not {}", first.size(), levels.len());
            return Err(EnvError::Options(message));
        }
        let expected = |k: usize| level_size(first.size(), k);
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

    /// The full chain down to a size of 1, each texel the mean of what it covers in the level before.
    ///
    /// Texels count with their solid angle, so the mean over the sphere stays the same in every level where sizes are
    /// powers of two. An odd size is halved with fractions of texels.
    #[must_use]
    pub fn averaged(map: CubeMap) -> Self {
        let mut levels = vec![map];
        while let Some(last) = levels.last()
            && last.size() > 1
        {
            levels.push(halved(last));
        }
        Self { levels }
    }

    /// The levels, the largest first; at least one.
    #[must_use]
    pub fn levels(&self) -> &[CubeMap] {
        &self.levels
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

/// The size of level `k` below a map of size `size`.
pub(crate) fn level_size(size: usize, k: usize) -> usize {
    size.checked_shr(k as u32).unwrap_or(0).max(1)
}

/// The levels from `size` down to 1.
pub(crate) fn level_count(size: usize) -> usize {
    size.max(1).ilog2() as usize + 1
}

/// The next level: each texel the mean of those it covers, weighted with their solid angles.
fn halved(map: &CubeMap) -> CubeMap {
    let (from, to) = (map.size(), map.size() / 2);
    let weights = Weights::new(from);
    let rows: Vec<Vec<[Rgb<f32>; FACES]>> =
        (0..to).into_par_iter().map(|y| (0..to).map(|x| mean_of_covered(map, &weights, x, y, to)).collect()).collect();
    let texel = |i: usize| rows[i / to % to][i % to][i / (to * to)];
    match CubeMap::new(to, (0..FACES * to * to).map(texel).collect()) {
        Ok(map) => map,
        Err(error) => unreachable!("{from} halved is {to}, and six faces were filled: {error}"),
    }
}

/// The solid angles of the texels of a face; a quarter of them, because the others mirror it.
struct Weights {
    size: usize,
    quarter: Vec<f64>,
}

impl Weights {
    fn new(size: usize) -> Self {
        let half = size.div_ceil(2);
        let quarter = (0..half * half).into_par_iter().map(|i| cube::solid_angle(size, i % half, i / half)).collect();
        Self { size, quarter }
    }

    fn solid_angle(&self, x: usize, y: usize) -> f64 {
        let mirrored = |i: usize| i.min(self.size - 1 - i);
        self.quarter[mirrored(y) * self.size.div_ceil(2) + mirrored(x)]
    }
}

/// The mean of what texel `(x, y)` of a face of `to` texels covers, on each face.
fn mean_of_covered(map: &CubeMap, weights: &Weights, x: usize, y: usize, to: usize) -> [Rgb<f32>; FACES] {
    let from = map.size();
    let (mut sums, mut weight): ([Rgb<f64>; FACES], f64) = ([Rgb::ZERO; FACES], 0.0);
    for (j, height) in covered(y, from, to) {
        for (i, width) in covered(x, from, to) {
            let solid_angle = width * height * weights.solid_angle(i, j);
            weight += solid_angle;
            for (face, sum) in sums.iter_mut().enumerate() {
                *sum += map.texel(face, i, j).widen().scale(solid_angle);
            }
        }
    }
    sums.map(|sum| Rgb::from(sum.scale(1.0 / weight).to_array().map(|c| c as f32)))
}

/// The texels of a row of `from` that texel `k` of a row of `to` covers, with how much of each.
fn covered(k: usize, from: usize, to: usize) -> impl Iterator<Item = (usize, f64)> {
    // In units of 1/to of a texel everything is whole.
    let (start, end) = (k * from, (k + 1) * from);
    (start / to..end.div_ceil(to)).map(move |i| {
        let overlap = end.min((i + 1) * to) - start.max(i * to);
        (i, overlap as f64 / to as f64)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(size: usize) -> CubeMap {
        CubeMap::from_fn(size, |s| Rgb::new(2.0 + s.x() as f32, 1.5 + s.y() as f32, (4.0 * s.z() as f32).exp()))
    }

    #[test]
    fn the_mean_stays_the_same_in_every_level() {
        // Texels are f32: each level may lose 2^-24 of it. Odd sizes share texels by area, not by solid angle.
        for (size, tolerance) in [(64, 1e-6), (16, 1e-6), (1, 1e-6), (63, 2e-2), (24, 2e-2)] {
            let chain = CubeMipChain::averaged(map(size));
            let mean = chain.base().mean();
            assert_eq!(chain.levels().len(), level_count(size), "levels of {size}");
            for level in chain.levels() {
                let error = (level.mean().b / mean.b - 1.0).abs().max((level.mean().r / mean.r - 1.0).abs());
                assert!(error < tolerance, "{size} to {}: {:?} against {mean:?}", level.size(), level.mean());
            }
        }
    }

    #[test]
    fn odd_sizes_share_the_texel_in_the_middle() {
        let covered: Vec<_> = (0..2).map(|k| covered(k, 5, 2).collect::<Vec<_>>()).collect();
        assert_eq!(covered[0], [(0, 1.0), (1, 1.0), (2, 0.5)], "left half of five");
        assert_eq!(covered[1], [(2, 0.5), (3, 1.0), (4, 1.0)], "right half of five");
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
