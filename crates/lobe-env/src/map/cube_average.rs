//! Area averaging of cube maps to another size.

use lobe_io::parallel;
use lobe_sh::{Coefficient, Rgb};

use crate::map::cube_map::CubeMap;
use crate::mapping::cube::{self, FACES};
use crate::mapping::mapping::Mapping;
use crate::mapping::solid_angles::SolidAngles;

/// A cube map in another size: each texel the mean of the texels it covers, weighted with solid angles.
///
/// A texel that the border between two new ones cuts is divided by the solid angle of its parts, so the mean over the
/// sphere is kept for every pair of sizes.
pub(crate) fn averaged_to(map: &CubeMap, size: usize) -> CubeMap {
    if map.size() == size {
        return map.clone();
    }
    let weights = Weights::new(map.size(), size);
    let rows: Vec<Vec<[Rgb<f32>; FACES]>> =
        parallel::map(size, &|y| (0..size).map(|x| weights.means(map, x, y)).collect());
    let texel = |i: usize| rows[i / size % size][i % size][i / (size * size)];
    match CubeMap::new(size, (0..FACES * size * size).map(texel).collect()) {
        Ok(map) => map,
        Err(error) => unreachable!("six faces of {size} were filled: {error}"),
    }
}

/// The weights with which a face of `to` texels a side averages one of `from` texels a side; the same for all faces.
struct Weights {
    from: usize,
    to: usize,
    /// Solid angles of the texels that are not cut.
    whole: SolidAngles,
}

impl Weights {
    fn new(from: usize, to: usize) -> Self {
        Self { from, to, whole: SolidAngles::of(Mapping::Cube, from, FACES * from) }
    }

    /// The mean of the texels that texel `(x, y)` covers, on each face.
    fn means(&self, map: &CubeMap, x: usize, y: usize) -> [Rgb<f32>; FACES] {
        let (mut sums, mut total): ([Rgb<f64>; FACES], f64) = ([Rgb::ZERO; FACES], 0.0);
        for (j, down) in covered(y, self.from, self.to) {
            for (i, across) in covered(x, self.from, self.to) {
                let solid_angle = self.solid_angle([i, j], across, down);
                total += solid_angle;
                for (face, sum) in sums.iter_mut().enumerate() {
                    *sum += map.texel(face, i, j).widen().scale(solid_angle);
                }
            }
        }
        sums.map(|sum| Rgb::narrow(Rgb::from(sum.to_array().map(|c| c / total))))
    }

    /// The solid angle of a part of texel `(i, j)`, from its borders in the units of [`covered`].
    fn solid_angle(&self, [i, j]: [usize; 2], across: [usize; 2], down: [usize; 2]) -> f64 {
        if [across, down].iter().all(|[start, end]| end - start == self.to) {
            return self.whole.get(i, j);
        }
        let at = |p: usize| (2 * p) as f64 / (self.from * self.to) as f64 - 1.0;
        cube::rect_solid_angle(across.map(at), down.map(at))
    }
}

/// The texels of a row of `from` that texel `k` of a row of `to` covers, with the extent of the covered part of each,
/// in units of 1/(`from · to`) of the row: a texel of `from` has `to` of them, and the other way around.
fn covered(k: usize, from: usize, to: usize) -> impl Iterator<Item = (usize, [usize; 2])> {
    let (start, end) = (k * from, (k + 1) * from);
    (start / to..end.div_ceil(to)).map(move |i| (i, [start.max(i * to), end.min((i + 1) * to)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_sizes_share_the_texel_in_the_middle() {
        let covered: Vec<_> = (0..2).map(|k| covered(k, 5, 2).collect::<Vec<_>>()).collect();
        assert_eq!(covered[0], [(0, [0, 2]), (1, [2, 4]), (2, [4, 5])], "left half of five");
        assert_eq!(covered[1], [(2, [5, 6]), (3, [6, 8]), (4, [8, 10])], "right half of five");
    }

    #[test]
    fn the_mean_is_the_same_in_every_size() {
        for from in [1, 2, 5, 8, 63] {
            let map = CubeMap::from_fn(from, |s| Rgb::new(2.0 + s.x() as f32, 1.0, (4.0 * s.z() as f32).exp()));
            for to in [1, 2, 3, 7, 8, 31, 32, 64] {
                let (found, mean) = (averaged_to(&map, to).mean(), map.mean());
                for c in 0..3 {
                    let error = (found.channel(c) / mean.channel(c) - 1.0).abs();
                    assert!(error < 1e-7, "{from} to {to}: {found:?} against {mean:?}");
                }
            }
        }
    }
}
