//! Rotation matrices of all bands by the recurrence of Ivanic and Ruedenberg, for one rotation of many expansions.

use crate::basis::index::{band_range, coefficient_count, order_of_slice};
use crate::prelude::*;
use crate::rotation::Rotation;
use crate::rotation::band_matrices::{band_columns, first_entry};
#[cfg(feature = "simd")]
use crate::rotation::lane_rotation::rotate_planes;
use crate::scalar::{Coefficient, Real};
#[cfg(feature = "simd")]
use crate::simd::Machine;

/// Vectors and rows of one block when many expansions are rotated: in `f32` their sums take half of the SSE registers.
const VECTOR_BLOCK: usize = 8;
const ROW_BLOCK: usize = 4;

/// Columns with `|n| > STEEP l` use the form of `P` that raises `n` with the band. At this ratio both forms have the
/// same largest row factor over the divisor `√D`, 5/4, which bounds the growth of errors: `l/√(l² - n²) = 2l/(l + n)`.
const STEEP: f64 = 0.6;

/// The matrices of all bands of one rotation, prepared to be applied to many expansions.
///
/// ```text
///   M_{mn}^l = u U + v V + w W                            for -l <= m, n <= l
///
///   u = √((l+m)(l-m)/D)                                   D = (l+n)(l-n) for |n| <= 3l/5, (l+|n|)(l+|n|-1) else
///   v = ½ √((1+δ_m0)(l+|m|-1)(l+|m|)/D) (1-2δ_m0)
///   w = -½ √((l-|m|-1)(l-|m|)/D) (1-δ_m0)
///
///   U = P_0(m, n)
///   V = m = 0:  P_1(1, n) + P_-1(-1, n)
///       m > 0:  P_1(m-1, n) √(1+δ_m1) - P_-1(1-m, n) (1-δ_m1)
///       m < 0:  P_1(m+1, n) (1-δ_m,-1) + P_-1(-m-1, n) √(1+δ_m,-1)
///   W = m > 0:  P_1(m+1, n) + P_-1(-m-1, n)
///       m < 0:  P_1(m-1, n) - P_-1(1-m, n)
///
///   P_i(a, n) = |n| <= 3l/5:  M_{i,0}^1 M_{a,n}^{l-1}
///               n > 3l/5:     M_{i,1}^1 M_{a,n-1}^{l-1} - M_{i,-1}^1 M_{a,1-n}^{l-1}
///               n < -3l/5:    M_{i,1}^1 M_{a,n+1}^{l-1} + M_{i,-1}^1 M_{a,-n-1}^{l-1}
/// ```
///
/// `M^1` is the rotation matrix with rows and columns in the order y, z, x. This is the basis without the
/// Condon-Shortley phase; entries are multiplied by `(-1)^(m+n)` for ours. [Ivanic and Ruedenberg 1996],
/// with V and W of the correction of 1998 (J. Phys. Chem. A 102, 9099). Built in `f64` and rounded once.
///
/// The paper has the last two forms of `P` for `|n| = l` only. They hold for all `|n| >= 2`, because
/// `(x + iy)(y_{l-1}^{n-1} + i y_{l-1}^{1-n})` is `y_l^n + i y_l^-n` times a factor, plus lower bands; and near
/// `|n| = l` the first form divides by little. As printed, the recurrence loses a digit every eleven bands and is 5e-11
/// off at order 64; in this form it stays within 1e-12 of [`Rotation::apply_into`], an independent route (test
/// `every_route_agrees_at_order_64`). `the_matrices_are_orthogonal` bounds the residual of `M Mᵀ`.
///
/// ```
/// use lobe_sh::rotation::RotationMatrices;
/// use lobe_sh::{Dir, Expansion as _, Rotation, ShL3};
///
/// let rotation = Rotation::from_axis_angle(Dir::Y, 0.3);
/// let matrices = RotationMatrices::<f64>::new(&rotation, 4);
/// let light = ShL3::<f64>::impulse(Dir::Z, 1.0);
/// let mut turned = ShL3::zero();
/// matrices.apply_into(light.coefficients(), turned.coefficients_mut());
/// assert!((turned.eval(rotation.rotate_dir(Dir::Z)) - light.eval(Dir::Z)).abs() < 1e-14);
/// ```
///
/// [Ivanic and Ruedenberg 1996]: https://doi.org/10.1021/jp953350u
#[derive(Clone, Debug)]
pub struct RotationMatrices<S> {
    order: usize,
    /// Band after band, each column after column.
    columns: Vec<S>,
}

impl<S: Real> RotationMatrices<S> {
    /// The matrices of bands `0..order`.
    #[must_use]
    pub fn new(rotation: &Rotation, order: usize) -> Self {
        let mut columns = Vec::with_capacity(first_entry(order));
        let mut band = BandMatrix { l: 0, rows: vec![1.0] };
        let one = BandMatrix::one(rotation);
        for l in 0..order {
            if l == 1 {
                band = one.clone();
            } else if l > 1 {
                band = band.next(&one);
            }
            let side = 2 * l + 1;
            for n in 0..side {
                columns.extend((0..side).map(|m| {
                    // The phases (-1)^m and (-1)^n; an index differs from m by l, a common sign that cancels.
                    let sign = if (m + n).is_multiple_of(2) { 1.0 } else { -1.0 };
                    S::from_f64(sign * band.rows[m * side + n])
                }));
            }
        }
        Self { order, columns }
    }

    /// The number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The entry of band `l` by which `f_ln` contributes to `f_lm`.
    ///
    /// # Panics
    /// If `l >= order` or `m` or `n` lies outside `-l..=l`.
    #[must_use]
    pub fn entry(&self, l: usize, m: isize, n: isize) -> S {
        let place = |m: isize| l.checked_add_signed(m).filter(|place| *place <= 2 * l);
        let (Some(m), Some(n)) = (place(m), place(n)) else { panic!("m and n must lie in -{l}..={l}, not {m}, {n}") };
        self.band(l)[n * (2 * l + 1) + m]
    }

    /// The coefficients of the rotated function.
    ///
    /// # Panics
    /// If the lengths differ, are no perfect square, or their order is above that of the matrices.
    pub fn apply_into<T: Coefficient<Scalar = S>>(&self, src: &[T], dst: &mut [T]) {
        assert_eq!(src.len(), dst.len(), "the rotated expansion has as many coefficients as the given one");
        for l in 0..self.order_within(order_of_slice(src)) {
            let dst = &mut dst[band_range(l)];
            dst.fill(T::ZERO);
            for (column, x) in self.band(l).chunks_exact(2 * l + 1).zip(&src[band_range(l)]) {
                for (dst, m) in dst.iter_mut().zip(column) {
                    *dst += x.scale(*m);
                }
            }
        }
    }

    /// Rotates `count` functions at once: `src[i * count + k]` is coefficient `i` of function `k`, likewise `dst`. In `f32` by
    /// the instructions of the [`Machine`].
    ///
    /// # Panics
    /// If the lengths differ, are not `n² count`, or the order is above that of the matrices.
    pub fn apply_many_into<T: Coefficient<Scalar = S>>(&self, count: usize, src: &[T], dst: &mut [T]) {
        assert_eq!(src.len(), dst.len(), "the rotated expansions have as many coefficients as the given ones");
        if count == 0 {
            assert!(src.is_empty(), "no expansions have no coefficients, not {}", src.len());
            return;
        }
        let order = self.order_within((src.len() / count).isqrt());
        assert_eq!(src.len(), coefficient_count(order) * count, "expected n² coefficients of {count} functions");
        #[cfg(feature = "simd")]
        let done = match (S::single_slice(&self.columns), T::single_slice(src), T::single_slice_mut(dst)) {
            (Some(columns), Some(src), Some(dst)) => rotate_planes(Machine::detect(), columns, order, count, src, dst),
            _ => 0,
        };
        #[cfg(not(feature = "simd"))]
        let done = 0;
        let whole_blocks = count - count % VECTOR_BLOCK;
        for l in 0..order {
            let range = band_range(l).start * count..band_range(l).end * count;
            let (src, dst) = (&src[range.clone()], &mut dst[range]);
            for start in (done..whole_blocks).step_by(VECTOR_BLOCK) {
                apply_block::<T, VECTOR_BLOCK>(self.band(l), count, start, src, dst);
            }
            for start in whole_blocks.max(done)..count {
                apply_block::<T, 1>(self.band(l), count, start, src, dst);
            }
        }
    }

    fn band(&self, l: usize) -> &[S] {
        band_columns(&self.columns, l)
    }

    /// All bands, each column after column.
    #[cfg(feature = "batch")]
    pub(crate) fn columns(&self) -> &[S] {
        &self.columns
    }

    fn order_within(&self, order: usize) -> usize {
        assert!(order <= self.order, "these matrices reach order {}, not {order}", self.order);
        order
    }
}

/// Applies the matrix of one band to `V` functions from `start`.
#[inline(always)]
fn apply_block<T: Coefficient, const V: usize>(
    matrix: &[T::Scalar],
    count: usize,
    start: usize,
    src: &[T],
    dst: &mut [T],
) {
    let side = matrix.len().isqrt();
    let whole_blocks = side - side % ROW_BLOCK;
    for row in (0..whole_blocks).step_by(ROW_BLOCK) {
        apply_rows::<T, V, ROW_BLOCK>(matrix, row, count, start, src, dst);
    }
    for row in whole_blocks..side {
        apply_rows::<T, V, 1>(matrix, row, count, start, src, dst);
    }
}

/// `R` rows from `row` of [`apply_block`].
#[inline(always)]
fn apply_rows<T: Coefficient, const V: usize, const R: usize>(
    matrix: &[T::Scalar],
    row: usize,
    count: usize,
    start: usize,
    src: &[T],
    dst: &mut [T],
) {
    let side = matrix.len().isqrt();
    let mut sums = [[T::ZERO; V]; R];
    for (column, src) in matrix.chunks_exact(side).zip(src.chunks_exact(count)) {
        let (Some(column), Some(src)) = (column[row..].first_chunk::<R>(), src[start..].first_chunk::<V>()) else {
            unreachable!("blocks lie inside the matrix and the functions");
        };
        for (sums, m) in sums.iter_mut().zip(column) {
            for (sum, x) in sums.iter_mut().zip(src) {
                *sum += x.scale(*m);
            }
        }
    }
    for (r, sums) in sums.iter().enumerate() {
        dst[(row + r) * count + start..][..V].copy_from_slice(sums);
    }
}

/// The matrix of one band, row by row, in the basis without the Condon-Shortley phase.
#[derive(Clone)]
struct BandMatrix {
    l: usize,
    rows: Vec<f64>,
}

impl BandMatrix {
    /// Band 1, in the order y, z, x.
    fn one(rotation: &Rotation) -> Self {
        let r = rotation.matrix();
        let order = [1, 2, 0];
        Self { l: 1, rows: order.iter().flat_map(|&m| order.map(|n| r[m][n])).collect() }
    }

    fn row(&self, m: isize) -> &[f64] {
        let side = 2 * self.l + 1;
        &self.rows[self.l.strict_add_signed(m) * side..][..side]
    }

    /// The matrix of the next band.
    fn next(&self, one: &Self) -> Self {
        let l = self.l + 1;
        let side = 2 * l + 1;
        let mut next = Self { l, rows: vec![0.0; side * side] };
        let scales: Vec<f64> = (0..side).map(|n| column_scale(l, n.abs_diff(l))).collect();
        for (row, m) in next.rows.chunks_exact_mut(side).zip(-(l as isize)..) {
            for (factor, i, a) in terms(l as isize, m) {
                self.add_p(factor, one.row(i), a, row);
            }
            for (x, scale) in row.iter_mut().zip(&scales) {
                *x *= scale;
            }
        }
        next
    }

    /// Adds `factor P_i(a, n)` for all `n`; `one` is row `i` of band 1.
    fn add_p(&self, factor: f64, one: &[f64], a: isize, row: &mut [f64]) {
        let before = self.row(a);
        let [from_minus, from_zero, from_plus] = [0, 1, 2].map(|k| factor * one[k]);
        let (l, last) = (self.l + 1, 2 * self.l);
        let flat = flat_columns(l);
        for (x, before) in row[l - flat..=l + flat].iter_mut().zip(&before[self.l - flat..]) {
            *x += from_zero * before;
        }
        // Column n of this band stands at l + n, column n - 1 of the band before at l - 1 + n - 1.
        for n in flat + 1..=l {
            let (plus, minus) = (before[l + n - 2], before[last - (l + n - 2)]);
            row[l + n] += from_plus * plus - from_minus * minus;
            row[l - n] += from_plus * minus + from_minus * plus;
        }
    }
}

/// The largest `|n|` of band `l` whose column uses the first form of `P`.
fn flat_columns(l: usize) -> usize {
    (STEEP * l as f64) as usize
}

/// `√(1/D)`, the part of `u`, `v` and `w` that depends on the column.
fn column_scale(l: usize, n: usize) -> f64 {
    let d = if n <= flat_columns(l) { (l + n) * (l - n) } else { (l + n) * (l + n - 1) };
    (d as f64).sqrt().recip()
}

/// Row `m` of band `l` as a sum of terms `factor P_i(a, n)`, given as `(factor, i, a)`.
fn terms(l: isize, m: isize) -> impl Iterator<Item = (f64, isize, isize)> {
    let size = m.abs();
    let root = |x: isize| (x as f64).sqrt();
    let u = root((l + m) * (l - m));
    let v = 0.5 * root((l + size - 1) * (l + size));
    let w = -0.5 * root((l - size - 1) * (l - size));
    let sqrt_2 = core::f64::consts::SQRT_2;
    let five = match m {
        0 => [(u, 0, 0), (-v * sqrt_2, 1, 1), (-v * sqrt_2, -1, -1), (0.0, 0, 0), (0.0, 0, 0)],
        1 => [(u, 0, 1), (v * sqrt_2, 1, 0), (0.0, 0, 0), (w, 1, 2), (w, -1, -2)],
        -1 => [(u, 0, -1), (0.0, 0, 0), (v * sqrt_2, -1, 0), (w, 1, -2), (-w, -1, 2)],
        2.. => [(u, 0, m), (v, 1, m - 1), (-v, -1, 1 - m), (w, 1, m + 1), (w, -1, -m - 1)],
        _ => [(u, 0, m), (v, 1, m + 1), (v, -1, -m - 1), (w, 1, m - 1), (-w, -1, 1 - m)],
    };
    // A factor vanishes if its row lies outside of band l - 1.
    five.into_iter().filter(|(factor, _, _)| *factor != 0.0)
}
