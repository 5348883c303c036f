//! Principal component analysis: the affine subspace nearest to a set of rows.

use lobe_io::parallel;
use lobe_sh::simd::Machine;

use crate::compression::eigen::{dot, leading, orthonormalized};

/// Pieces into which the sum over a large set is cut, whatever the number of threads.
const PIECES: usize = 8;

/// A set smaller than this is summed in one piece.
const SMALL: usize = 2048;

/// Rows that are added to the covariance in one pass.
const TOGETHER: usize = 4;

/// Rows of equal width, one after the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows<'a> {
    values: &'a [f32],
    width: usize,
}

impl<'a> Rows<'a> {
    pub(crate) fn new(values: &'a [f32], width: usize) -> Self {
        debug_assert!(width > 0 && values.len().is_multiple_of(width), "whole rows");
        Self { values, width }
    }

    pub(crate) fn width(self) -> usize {
        self.width
    }

    pub(crate) fn count(self) -> usize {
        self.values.len() / self.width
    }

    pub(crate) fn row(self, r: u32) -> &'a [f32] {
        &self.values[r as usize * self.width..][..self.width]
    }
}

/// A mean and orthonormal directions from it, the one of largest variance first.
///
/// ```text
///   x ≈ m + Σ_j ((x - m)·b_j) b_j        b_j: eigenvectors of Σ (x - m)(x - m)ᵀ, largest eigenvalues first
/// ```
///
/// Of all affine subspaces of its dimension it has the least sum of squared distances to the rows (Eckart and Young
/// 1936).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Subspace {
    pub(crate) mean: Vec<f64>,
    /// Direction after direction; fewer than asked for where the rows span fewer.
    pub(crate) bases: Vec<f64>,
}

impl Subspace {
    /// Fits the rows `members` with at most `components` directions.
    ///
    /// The eigenvectors are those of the covariance or, where there are fewer rows than numbers in a row, of the matrix
    /// of scalar products of the rows. Without rows the mean is zero.
    pub(crate) fn fit(rows: Rows<'_>, members: &[u32], components: usize) -> Self {
        let mean = mean_of(rows, members);
        if components == 0 || members.len() < 2 {
            return Self { mean, bases: Vec::new() };
        }
        // Take the eigenvectors of the smaller of the two matrices.
        let bases = if members.len() < rows.width() {
            directions_by_products(rows, members, &mean, components)
        } else {
            let covariance = covariance(rows, members, &mean);
            let (values, vectors) = leading(&covariance, rows.width(), components);
            debug_assert_eq!(vectors.len(), values.len() * rows.width(), "a vector for each value");
            vectors
        };
        Self { mean, bases }
    }

    /// The number of directions.
    pub(crate) fn rank(&self) -> usize {
        self.bases.len() / self.mean.len().max(1)
    }

    /// The coordinates of a row, handed to `take` one after the other, and its squared distance from the subspace.
    pub(crate) fn project(&self, row: &[f32], centered: &mut Vec<f64>, mut take: impl FnMut(usize, f64)) -> f64 {
        centered.clear();
        centered.extend(row.iter().zip(&self.mean).map(|(x, m)| f64::from(*x) - m));
        // Taking each direction's part away keeps the digits that a difference of squares would lose.
        for (j, b) in self.bases.chunks_exact(self.mean.len()).enumerate() {
            let w = dot(centered, b);
            take(j, w);
            for (c, b) in centered.iter_mut().zip(b) {
                *c -= w * b;
            }
        }
        dot(centered, centered)
    }

    /// The squared distance of a row.
    pub(crate) fn error(&self, row: &[f32], centered: &mut Vec<f64>) -> f64 {
        self.project(row, centered, |_, _| {})
    }
}

fn mean_of(rows: Rows<'_>, members: &[u32]) -> Vec<f64> {
    let mut sums = summed(members, rows.width(), &|members, sums| {
        for r in members {
            for (sum, x) in sums.iter_mut().zip(rows.row(*r)) {
                *sum += f64::from(*x);
            }
        }
    });
    let count = members.len().max(1) as f64;
    sums.iter_mut().for_each(|sum| *sum /= count);
    sums
}

/// The sum over all members of what `add` adds, in pieces of fixed size, put together in their order.
fn summed(members: &[u32], len: usize, add: &(dyn Fn(&[u32], &mut [f64]) + Sync)) -> Vec<f64> {
    let piece = if members.len() < SMALL { members.len().max(1) } else { members.len().div_ceil(PIECES) };
    let pieces: Vec<&[u32]> = members.chunks(piece).collect();
    let partials: Vec<Vec<f64>> = parallel::map(pieces.len(), &|k| {
        let mut sums = vec![0.0; len];
        add(pieces[k], &mut sums);
        sums
    });
    let mut partials = partials.into_iter();
    let mut total = partials.next().unwrap_or_else(|| vec![0.0; len]);
    for partial in partials {
        total.iter_mut().zip(partial).for_each(|(sum, x)| *sum += x);
    }
    total
}

/// `Σ (x - m)(x - m)ᵀ`; only `j >= i` of row `i` is filled.
fn covariance(rows: Rows<'_>, members: &[u32], mean: &[f64]) -> Vec<f64> {
    let d = rows.width();
    let arch = Machine::detect().arch();
    summed(members, d * d, &|members, sums| {
        let mut centered: [Vec<f64>; TOGETHER] = std::array::from_fn(|_| vec![0.0; d]);
        for four in members.chunks(TOGETHER) {
            for (k, centered) in centered.iter_mut().enumerate() {
                match four.get(k) {
                    Some(r) => center_into(rows.row(*r), mean, centered),
                    None => centered.fill(0.0),
                }
            }
            arch.dispatch(AddSquares(&centered, sums));
        }
    })
}

fn center_into(row: &[f32], mean: &[f64], out: &mut [f64]) {
    for ((out, x), m) in out.iter_mut().zip(row).zip(mean) {
        *out = f64::from(*x) - m;
    }
}

/// To be compiled for the machine's instructions: a type, because closures are not inlined there.
struct AddSquares<'a>(&'a [Vec<f64>; TOGETHER], &'a mut [f64]);

impl pulp::NullaryFnOnce for AddSquares<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        add_squares(self.0, self.1);
    }
}

#[inline(always)]
fn add_squares(rows: &[Vec<f64>; TOGETHER], sums: &mut [f64]) {
    let d = rows[0].len();
    let [a, b, c, e] = rows.each_ref().map(|row| &row[..d]);
    for i in 0..d {
        let (ai, bi, ci, ei) = (a[i], b[i], c[i], e[i]);
        let out = &mut sums[i * d..(i + 1) * d];
        for j in i..d {
            out[j] += (ai * a[j] + bi * b[j]) + (ci * c[j] + ei * e[j]);
        }
    }
}

/// From `G_ab = (x_a - m)·(x_b - m) = U Λ Uᵀ` come the directions `b_j = Σ_a u_aj (x_a - m) / √λ_j`.
fn directions_by_products(rows: Rows<'_>, members: &[u32], mean: &[f64], components: usize) -> Vec<f64> {
    let (n, d) = (members.len(), rows.width());
    let mut centered = vec![0.0; n * d];
    for (r, out) in members.iter().zip(centered.chunks_exact_mut(d)) {
        center_into(rows.row(*r), mean, out);
    }
    let row = |a: usize| &centered[a * d..(a + 1) * d];
    let mut products = vec![0.0; n * n];
    for a in 0..n {
        for b in a..n {
            products[a * n + b] = dot(row(a), row(b));
        }
    }
    // The centered rows sum to zero: they span one dimension less than there are rows.
    let (_, vectors) = leading(&products, n, components.min(n - 1));
    let mut bases: Vec<f64> = Vec::with_capacity(components * d);
    for u in vectors.chunks_exact(n) {
        let mut b = vec![0.0; d];
        for (a, u) in u.iter().enumerate() {
            b.iter_mut().zip(row(a)).for_each(|(b, x)| *b += u * x);
        }
        if let Some(b) = orthonormalized(b, &bases) {
            bases.extend(b);
        }
    }
    bases
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    /// `count` rows of `width` numbers that vary along `rank` directions about a mean.
    fn rows_of_rank(count: usize, width: usize, rank: usize, seed: u64) -> Vec<f32> {
        let mut random = Random::new(seed);
        let mean = random.signed_vec(width);
        let directions: Vec<_> = (0..rank).map(|_| random.signed_vec(width)).collect();
        let mut rows = Vec::new();
        for _ in 0..count {
            let weights = random.signed_vec(rank);
            rows.extend((0..width).map(|i| {
                let varied: f64 = weights.iter().zip(&directions).map(|(w, d)| w * d[i]).sum();
                (mean[i] + varied) as f32
            }));
        }
        rows
    }

    fn error(space: &Subspace, rows: Rows<'_>) -> f64 {
        (0..rows.count() as u32).map(|r| space.error(rows.row(r), &mut Vec::new())).sum()
    }

    #[test]
    fn a_planted_subspace_is_found_from_either_side() {
        for (count, width) in [(200, 9), (7, 48), (5000, 16)] {
            let values = rows_of_rank(count, width, 3, 1);
            let rows = Rows::new(&values, width);
            let members: Vec<u32> = (0..count as u32).collect();
            let energy: f64 = values.iter().map(|x| f64::from(*x).powi(2)).sum();
            let found = Subspace::fit(rows, &members, 3);
            assert_eq!(found.rank(), 3, "{count} rows of {width}");
            // The rows were rounded to f32.
            assert!(error(&found, rows) < 1e-13 * energy, "{count} rows of {width}: {}", error(&found, rows));
            let fewer = Subspace::fit(rows, &members, 2);
            assert!(error(&fewer, rows) > 1e-4 * energy, "two directions do not do: {}", error(&fewer, rows));
            assert!(
                (0..2 * width).all(|i| (fewer.bases[i] - found.bases[i]).abs() < 1e-9),
                "the first two are the same"
            );
        }
    }

    #[test]
    fn directions_are_orthonormal_and_no_worse_than_any_other() {
        let values = rows_of_rank(300, 16, 16, 2);
        let rows = Rows::new(&values, 16);
        let members: Vec<u32> = (0..300).collect();
        let found = Subspace::fit(rows, &members, 4);
        for i in 0..4 {
            for j in 0..4 {
                let product = dot(&found.bases[i * 16..][..16], &found.bases[j * 16..][..16]);
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-13, "b_{i}·b_{j} = {product}");
            }
        }
        let best = error(&found, rows);
        let mut random = Random::new(3);
        for trial in 0..50 {
            let mut bases: Vec<f64> = Vec::new();
            for j in 0..4 {
                let turned = found.bases[j * 16..][..16].iter().map(|b| b + 0.1 * random.signed()).collect();
                bases.extend(orthonormalized(turned, &bases).unwrap());
            }
            let other = error(&Subspace { mean: found.mean.clone(), bases }, rows);
            assert!(other >= best, "trial {trial}: {other} is below {best}");
        }
    }

    #[test]
    fn what_does_not_vary_has_no_directions() {
        let rows = [0.5_f32, 1.0, 0.5, 1.0, 0.5, 1.0];
        let rows = Rows::new(&rows, 2);
        for members in [&[][..], &[1], &[0, 1, 2]] {
            let found = Subspace::fit(rows, members, 2);
            assert_eq!(found.rank(), 0, "{members:?}");
            let mean = if members.is_empty() { [0.0, 0.0] } else { [0.5, 1.0] };
            assert_eq!(found.mean, mean, "{members:?}");
        }
    }
}
