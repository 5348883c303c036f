//! Importance sampling of a lobe, with filtered lookups into a mip chain of a cube map.

use std::borrow::Cow;
use std::f64::consts::PI;

use lobe_io::parallel;
use lobe_sh::vector::tangents_along_axis;
use lobe_sh::{Coefficient, Dir, Rgb};

use crate::CubeMap;
use crate::map::cube_average::averaged_to;
use crate::mapping::cube::{self, FACES};
use crate::reflection::specular_lobe::{Kernel, integral};

/// The number of steps in the tabulated cumulative distribution of the lobe.
const STEPS: usize = 4096;

/// The golden angle, which spreads points evenly over a disc.
const GOLDEN_ANGLE: f64 = PI * (3.0 - 2.236_067_977_499_79);

/// The footprint of a sample, in units of the solid angle it represents, decides its mip level: 1 leaves gaps and
/// overlaps between samples, in which a small light is too dark or too bright by a quarter; larger footprints blur
/// narrow lobes.
const FOOTPRINT: f64 = 4.0;

/// Smaller faces are enlarged to this size: interpolated between texels of theirs, a sun of one texel would be up to a
/// tenth darker under the narrowest lobe of which the error is promised, α = 1/16.
const LEAST_SIZE: usize = 64;

/// Larger faces are enlarged to the next of the sizes between a power of two and its double that divide the octave into so
/// many steps: to 2 or 3 times a power of two, so by less than a half. A power of two itself stays as it is. With four steps, from 100
/// to 112, a sun of one texel would be spread so that it is 4.5 % of the peak off under a lobe of α = 1/16.
const STEPS_PER_OCTAVE: usize = 2;

/// The mip chain of a source, each face with a border of its neighbors' texels.
pub(crate) struct ImportanceFilter {
    levels: Vec<Bordered>,
}

struct Bordered {
    size: usize,
    texels: Vec<[f32; 3]>,
}

/// A sample about the axis z: its direction, and its mip level in the middle of a face.
pub(crate) struct Sample {
    s: [f32; 3],
    level: f32,
}

impl ImportanceFilter {
    /// Builds the mip chain of the source made [`halvable`]: each level is the next finer one under a tent filter of
    /// twice its width. Means of 2 x 2 texels would move a small light to the middle of its texel, by up to one and a
    /// half texels of the source in level 2. The coarsest levels, of 7, 5 or 3 texels, cannot be halved, and are averaged.
    pub(crate) fn new(source: &CubeMap) -> Self {
        let mut level = halvable(source);
        let mut levels = Vec::new();
        loop {
            let (finer, size) = (Bordered::new(&level), level.size());
            if size > 1 {
                let half = size.div_ceil(2);
                level = Cow::Owned(if size.is_multiple_of(2) { finer.halved(half) } else { averaged_to(&level, half) });
            }
            levels.push(finer);
            if size == 1 {
                return Self { levels };
            }
        }
    }

    /// The samples for a kernel, all of the same weight.
    ///
    /// Sample `i` of `N` is at the angle within which the fraction `(i + ½)/N` of the kernel's integral lies. It
    /// represents the solid angle `1/(N p)`, `p = K/∫K`, and is looked up where texels are [`FOOTPRINT`] times as
    /// large. Towards `s` a texel of a cube has the solid angle `4 m³/size²`, `m` the largest of `|x|`, `|y|`, `|z|`.
    pub(crate) fn table(&self, kernel: &impl Kernel, samples: usize) -> Vec<Sample> {
        let base = self.levels[0].size as f64;
        let texel = 4.0 / (base * base);
        let total = integral(kernel);
        let within = shares(kernel);
        let mut step = 0;
        (0..samples)
            .map(|i| {
                let share = (i as f64 + 0.5) / samples as f64;
                while step + 2 < within.len() && within[step + 1].1 < share {
                    step += 1;
                }
                let ((d0, p0), (d1, p1)) = (within[step], within[step + 1]);
                let d = d0 + (d1 - d0) * if p1 > p0 { ((share - p0) / (p1 - p0)).clamp(0.0, 1.0) } else { 0.5 };
                let own = total / (samples as f64 * kernel.exact(d).max(f64::MIN_POSITIVE));
                let level = 0.5 * (FOOTPRINT * own.min(4.0 * PI) / texel).log2();
                let (sin, cos) = (GOLDEN_ANGLE * i as f64).sin_cos();
                let aside = (d * (2.0 - d)).max(0.0).sqrt();
                let s = [aside * cos, aside * sin, 1.0 - d].map(|c| c as f32);
                Sample { s, level: level as f32 }
            })
            .collect()
    }

    /// The average about `r`.
    pub(crate) fn towards(&self, samples: &[Sample], r: Dir) -> Rgb<f32> {
        let r = r.to_array();
        let [u, v] = tangents_along_axis(r);
        let axes = [u, v, r].map(|axis| axis.map(|c| c as f32));
        let last = self.levels.len() - 1;
        let mut sum = [0.0_f64; 3];
        for sample in samples {
            let s: [f32; 3] =
                std::array::from_fn(|k| sample.s[0] * axes[0][k] + sample.s[1] * axes[1][k] + sample.s[2] * axes[2][k]);
            let place = Place::new(s);
            let level = (sample.level + place.finer).clamp(0.0, last as f32);
            let below = (level as usize).min(last.saturating_sub(1));
            let t = level - below as f32;
            let fine = self.levels[below].at(&place);
            let coarse = self.levels[(below + 1).min(last)].at(&place);
            for c in 0..3 {
                sum[c] += f64::from(fine[c] + t * (coarse[c] - fine[c]));
            }
        }
        Rgb::narrow(Rgb::from(sum.map(|c| c / samples.len() as f64)))
    }
}

/// The source averaged to the next size that can be halved down to a few texels, at least [`LEAST_SIZE`]; beyond the
/// largest such cube as it is.
///
/// [`Bordered::halved`] weighs texels evenly only at exactly half the size: from 31 to 15 or from 25 to 12 most of a
/// small light would be lost, or counted twice. So a face has up to 9/4 as many texels as that of the source, where the
/// next power of two would have up to four times as many.
fn halvable(source: &CubeMap) -> Cow<'_, CubeMap> {
    let size = halvable_size(source.size());
    if size == source.size() || CubeMap::check_size(size).is_err() {
        return Cow::Borrowed(source);
    }
    Cow::Owned(averaged_to(source, size))
}

fn halvable_size(size: usize) -> usize {
    let octave = size.max(LEAST_SIZE).next_power_of_two() / 2;
    size.max(LEAST_SIZE).next_multiple_of(octave / STEPS_PER_OCTAVE)
}

/// A face and the point on it, in `[0, 1]`.
struct Place {
    face: usize,
    s: f32,
    t: f32,
    /// The difference in mip level to the middle of the face: `-3/2 log₂ m`.
    finer: f32,
}

impl Place {
    /// As [`cube::face_from_dir`], in single precision, for a unit vector.
    #[inline(always)]
    fn new(v: [f32; 3]) -> Self {
        let (face, major, a, b) = cube::major_face(v);
        let half = 0.5 / major;
        // -ln(1 - u) by its series: off by 0.01 levels in the corners.
        let u = 1.0 - major;
        let finer = 1.5 * std::f32::consts::LOG2_E * u * (1.0 + u * (0.5 + u * (1.0 / 3.0 + u * 0.25)));
        Self { face, s: half * a + 0.5, t: half * b + 0.5, finer }
    }
}

impl Bordered {
    fn new(map: &CubeMap) -> Self {
        let size = map.size();
        let inside = |i: isize| (0..size as isize).contains(&i);
        let get = |face: usize, x: isize, y: isize| {
            let (face, x, y) =
                if inside(x) && inside(y) { (face, x as usize, y as usize) } else { cube::neighbor(size, face, x, y) };
            map.texel(face, x, y).widen()
        };
        let mut texels = Vec::with_capacity(FACES * (size + 2) * (size + 2));
        for face in 0..FACES {
            for y in -1..=size as isize {
                for x in -1..=size as isize {
                    let (near_x, near_y) = (x.clamp(0, size as isize - 1), y.clamp(0, size as isize - 1));
                    let texel = if inside(x) || inside(y) {
                        get(face, x, y)
                    } else {
                        // Three texels meet in a corner.
                        let sum = get(face, near_x, near_y) + get(face, x, near_y) + get(face, near_x, y);
                        Rgb::from(sum.to_array().map(|c| c / 3.0))
                    };
                    texels.push(texel.to_array().map(|c| c as f32));
                }
            }
        }
        Self { size, texels }
    }

    /// Halves the map to `size`: every texel is the mean of four places, where tents along both axes weigh 1, 3, 3, 1.
    fn halved(&self, size: usize) -> CubeMap {
        let step = 1.0 / size as f32;
        let texel = |i: usize| {
            let (x, line) = (i % size, i / size);
            let (face, y) = (line / size, line % size);
            let mut sum = [0.0; 3];
            for (right, down) in [(-0.375, -0.375), (0.375, -0.375), (-0.375, 0.375), (0.375, 0.375)] {
                let at = |i: usize, aside: f32| (i as f32 + 0.5 + aside) * step;
                let value = self.at(&Place { face, s: at(x, right), t: at(y, down), finer: 0.0 });
                sum = [0, 1, 2].map(|c| sum[c] + 0.25 * value[c]);
            }
            Rgb::from(sum)
        };
        let mut texels = vec![Rgb::ZERO; FACES * size * size];
        parallel::fill(&mut texels, size, &texel);
        match CubeMap::new(size, texels) {
            Ok(map) => map,
            Err(error) => unreachable!("six faces of {size} were filled: {error}"),
        }
    }

    #[inline(always)]
    fn at(&self, place: &Place) -> [f32; 3] {
        let size = self.size as f32;
        let (x, y) = (place.s * size + 0.5, place.t * size + 0.5);
        let (left, top) = ((x as usize).min(self.size), (y as usize).min(self.size));
        let (s, t) = (x - left as f32, y - top as f32);
        let stride = self.size + 2;
        let at = (place.face * stride + top) * stride + left;
        let (upper, lower) = (&self.texels[at..][..2], &self.texels[at + stride..][..2]);
        std::array::from_fn(|c| {
            let above = upper[0][c] + s * (upper[1][c] - upper[0][c]);
            let below = lower[0][c] + s * (lower[1][c] - lower[0][c]);
            above + t * (below - above)
        })
    }
}

/// The cumulative distribution of the kernel: pairs of `d` and the integral from the axis to `d`, from 0 to 1; `d` is
/// clustered towards the axis.
fn shares(kernel: &impl Kernel) -> Vec<(f64, f64)> {
    let at = |i: usize| 2.0 * (i as f64 / STEPS as f64).powi(6);
    let mut sum = 0.0;
    let mut out = vec![(0.0, 0.0)];
    for i in 0..STEPS {
        let (start, end) = (at(i), at(i + 1));
        let middle = kernel.exact(0.5 * (start + end));
        sum += (end - start) / 6.0 * (kernel.exact(start) + 4.0 * middle + kernel.exact(end));
        out.push((end, sum));
    }
    out.iter_mut().for_each(|entry| entry.1 /= sum);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_grow_by_less_than_a_half_and_powers_of_two_stay() {
        for size in 65..5000_usize {
            let found = halvable_size(size);
            assert!(found >= size && 2 * found < 3 * size, "{size} became {found}");
            if size.is_power_of_two() {
                assert_eq!(found, size, "a power of two");
            }
            let odd = found >> found.trailing_zeros();
            assert!(odd <= 3, "{size} became {found}, {odd} times a power of two");
        }
        for size in 1..=LEAST_SIZE {
            assert_eq!(halvable_size(size), LEAST_SIZE, "{size}");
        }
    }

    #[test]
    fn every_level_has_the_light_of_the_source_and_half_the_size() {
        // Tents are even on a face, not on the sphere.
        const TOLERANCE: f64 = 0.01;
        for size in [65, 90, 100, 128] {
            let source = CubeMap::from_fn(size, |s| Rgb::new(1.0, 2.0 + s.z() as f32, (s.x() as f32).exp()));
            let filter = ImportanceFilter::new(&source);
            let sizes: Vec<usize> = filter.levels.iter().map(|level| level.size).collect();
            assert!(sizes[0] >= size && sizes.last() == Some(&1), "{size}: {sizes:?}");
            assert!(sizes.windows(2).all(|pair| pair[1] == pair[0].div_ceil(2)), "{size}: {sizes:?}");
            let mean = source.mean().to_array();
            for level in &filter.levels {
                let stride = level.size + 2;
                let inside = |i: usize| {
                    let (face, x, y) = (i / (level.size * level.size), i % level.size, i / level.size % level.size);
                    level.texels[(face * stride + y + 1) * stride + x + 1]
                };
                let texels = (0..FACES * level.size * level.size).map(|i| Rgb::from(inside(i))).collect();
                let found = CubeMap::new(level.size, texels).unwrap().mean().to_array();
                for (found, mean) in found.into_iter().zip(mean) {
                    let error = (found / mean - 1.0).abs();
                    assert!(error < TOLERANCE, "{size}, level of {}: {found} against {mean}", level.size);
                }
            }
        }
    }
}
