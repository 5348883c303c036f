//! Nearest-subspace search for every row in single precision: candidates, which the caller checks in full precision.

use lobe_io::parallel;
use lobe_sh::simd::Machine;
use pulp::NullaryFnOnce;

use crate::compression::pca::{Rows, Subspace};

/// Numbers multiplied at once; rows are filled up with zeros to a multiple.
const LANES: usize = 8;

/// Rows that share each load of a direction.
const TOGETHER: usize = 4;

/// Blocks of [`TOGETHER`] rows that a thread takes at a time; a subspace stays in the first-level cache meanwhile.
const CHUNK: usize = 16;

/// The rows less a common center, ready to be compared with subspaces.
///
/// ```text
///   |x - m|² - Σ_j ((x - m)·b_j)² = |x|² + |m|² - 2 x·m - Σ_j (x·b_j - m·b_j)²
/// ```
///
/// in `f32`, without `|x|²`, which all subspaces share. With the center taken away the terms that cancel are small.
pub(crate) struct Nearest {
    padded: Vec<f32>,
    stride: usize,
    count: usize,
    center: Vec<f64>,
}

/// A subspace as [`Nearest`] needs it: mean and directions filled up with zeros, `|m|²` and `m·b_j`.
struct Packed {
    rows: Vec<f32>,
    constants: Vec<f32>,
}

impl Nearest {
    pub(crate) fn new(rows: Rows<'_>, center: Vec<f64>) -> Self {
        let stride = rows.width().next_multiple_of(LANES);
        let count = rows.count();
        let mut padded = vec![0.0; count.next_multiple_of(TOGETHER) * stride];
        for r in 0..count {
            let out = &mut padded[r * stride..];
            for ((out, x), c) in out.iter_mut().zip(rows.row(r as u32)).zip(&center) {
                *out = (f64::from(*x) - c) as f32;
            }
        }
        Self { padded, stride, count, center }
    }

    /// The nearest of `spaces` to every row, to the rounding of `f32`; the first of equals. Where the row's space in
    /// `other_than` is the only one, it is that.
    pub(crate) fn find(&self, spaces: &[Subspace], other_than: Option<&[u32]>) -> Vec<u32> {
        let packed: Vec<Packed> = spaces.iter().map(|space| self.pack(space)).collect();
        let mut found = vec![0; self.count];
        if let Some(current) = other_than {
            found.copy_from_slice(current);
        }
        found.resize(self.count.next_multiple_of(TOGETHER), 0);
        let arch = Machine::detect().arch();
        parallel::rows(&mut found, CHUNK * TOGETHER, &|chunk, found| {
            let rows = &self.padded[chunk * CHUNK * TOGETHER * self.stride..][..found.len() * self.stride];
            let (stride, spaces, other) = (self.stride, &packed[..], other_than.is_some());
            arch.dispatch(Find { rows, stride, spaces, found, other });
        });
        found.truncate(self.count);
        found
    }

    fn pack(&self, space: &Subspace) -> Packed {
        let mean: Vec<f64> = space.mean.iter().zip(&self.center).map(|(m, c)| m - c).collect();
        let vectors = std::iter::once(&mean[..]).chain(space.bases.chunks_exact(mean.len()));
        let (mut rows, mut constants) = (Vec::new(), Vec::new());
        for v in vectors {
            constants.push(v.iter().zip(&mean).map(|(v, m)| v * m).sum::<f64>() as f32);
            rows.extend(v.iter().map(|v| *v as f32));
            rows.resize(constants.len() * self.stride, 0.0);
        }
        Packed { rows, constants }
    }
}

/// Rows and subspaces, to be compiled for the machine's instructions: a type, because closures are not inlined there.
struct Find<'a> {
    rows: &'a [f32],
    stride: usize,
    spaces: &'a [Packed],
    found: &'a mut [u32],
    other: bool,
}

impl NullaryFnOnce for Find<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        find_in(self.rows, self.stride, self.spaces, self.found, self.other);
    }
}

#[inline(always)]
fn find_in(rows: &[f32], stride: usize, spaces: &[Packed], found: &mut [u32], other: bool) {
    let mut least = [f32::INFINITY; CHUNK * TOGETHER];
    let mut current = [u32::MAX; CHUNK * TOGETHER];
    if other {
        current[..found.len()].copy_from_slice(found);
    }
    let current = current.as_chunks::<TOGETHER>().0;
    for (k, space) in spaces.iter().enumerate() {
        let blocks = rows.chunks_exact(TOGETHER * stride);
        let results = found.as_chunks_mut::<TOGETHER>().0.iter_mut().zip(least.as_chunks_mut::<TOGETHER>().0);
        for ((rows, current), (found, least)) in blocks.zip(current).zip(results) {
            let distances = distances(rows, stride, space);
            for r in 0..TOGETHER {
                if distances[r] < least[r] && current[r] != k as u32 {
                    (least[r], found[r]) = (distances[r], k as u32);
                }
            }
        }
    }
}

/// Squared distances less `|x|²`.
#[inline(always)]
fn distances(rows: &[f32], stride: usize, space: &Packed) -> [f32; TOGETHER] {
    let mut out = [0.0; TOGETHER];
    for (j, (v, constant)) in space.rows.chunks_exact(stride).zip(&space.constants).enumerate() {
        let along = dots(rows, stride, v);
        for r in 0..TOGETHER {
            if j == 0 {
                out[r] = constant - 2.0 * along[r];
            } else {
                let w = along[r] - constant;
                out[r] -= w * w;
            }
        }
    }
    out
}

#[inline(always)]
fn dots(rows: &[f32], stride: usize, v: &[f32]) -> [f32; TOGETHER] {
    let mut sums = [[0.0_f32; LANES]; TOGETHER];
    let [a, b, c, d] = std::array::from_fn(|r| rows[r * stride..(r + 1) * stride].as_chunks::<LANES>().0);
    for (i, v) in v.as_chunks::<LANES>().0.iter().enumerate() {
        let four = [&a[i], &b[i], &c[i], &d[i]];
        for (sums, row) in sums.iter_mut().zip(four) {
            for k in 0..LANES {
                sums[k] += row[k] * v[k];
            }
        }
    }
    sums.map(|s| ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    #[test]
    fn what_is_found_is_nearest_to_the_rounding_of_f32() {
        let mut random = Random::new(4);
        for (count, width, components) in [(203, 9, 0), (64, 27, 2), (501, 48, 5)] {
            let values: Vec<f32> = random.signed_vec(count * width).iter().map(|x| (x + 3.0) as f32).collect();
            let rows = Rows::new(&values, width);
            let members = |k: u32| (0..count as u32).filter(|r| r % 5 == k).collect::<Vec<_>>();
            let spaces: Vec<_> = (0..5).map(|k| Subspace::fit(rows, &members(k), components)).collect();
            let found = Nearest::new(rows, vec![3.0; width]).find(&spaces, None);
            let others = Nearest::new(rows, vec![3.0; width]).find(&spaces, Some(&found));
            for r in 0..count as u32 {
                let errors: Vec<f64> = spaces.iter().map(|s| s.error(rows.row(r), &mut Vec::new())).collect();
                let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
                let taken = errors[found[r as usize] as usize];
                assert!(taken <= least + 1e-5 * width as f64, "row {r} of {width}: {taken}, least {least}");
                let other = others[r as usize];
                let second = (0..5)
                    .filter(|k| *k != found[r as usize] as usize)
                    .map(|k| errors[k])
                    .fold(f64::INFINITY, f64::min);
                let taken = errors[other as usize];
                assert!(other != found[r as usize], "row {r} of {width}: another one");
                assert!(taken <= second + 1e-5 * width as f64, "row {r} of {width}: {taken}, second {second}");
            }
        }
    }
}
