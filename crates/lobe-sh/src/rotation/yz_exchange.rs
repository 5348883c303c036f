//! The exchange of the y and z axes, as matrices on the coefficients of each band, from Wigner's d-matrices of the angle π/2.

use core::f64::consts::SQRT_2;

use crate::basis::index::{band_range, order_of_slice};
use crate::once::Once;
use crate::prelude::*;
use crate::rotation::high_bands::{FIRST_HIGH_BAND, exchange_high_bands};
use crate::scalar::{Coefficient, Real};

/// Rows of a [`Block`] that are summed together: one AVX register of `f64`, one SSE register of `f32`.
const LANES: usize = 4;

/// The matrices `J_l` that exchange y and z in bands `0..order`: if `g(x, y, z) = f(x, z, y)` then `g = J f`.
///
/// ```text
///   J_(l,±m')(l,±m) = (-1)^(⌊m/2⌋ + ⌊m'/2⌋ + l(m + m')) 2 B_{l-m',l-m}^{2l} / √2^([m=0] + [m'=0])       m, m' >= 0
/// ```
///
/// between functions of the same parity in x whose parities in y and z are exchanged; all other entries vanish.
/// `J` is symmetric and its own inverse. `B` is the matrix of [`WignerHalfPi`]. The test
/// `the_exchange_is_its_own_inverse` bounds the error at order 64 by 1e-13.
///
/// Source: `J` has the role that [Pinchon and Hoggan 2007] give it; it is computed from the spinors here.
///
/// [Pinchon and Hoggan 2007]: https://doi.org/10.1088/1751-8113/40/7/011
//
// J is a product of rotations and a reflection, y → -y: J = M_y R_z(-90°) R_y(90°) R_z(90°), where (x, y, z) becomes
// (-y, x, z), (z, x, y), (x, -z, y), (x, z, y).
//
// The first, third and fourth only exchange y_l^m with y_l^-m and change signs. With the complex functions
// Y_l^m, y_l^m = (Y_l^m + (-1)^m Y_l^-m)/√2 for m > 0 and y_l^-m = (Y_l^m - (-1)^m Y_l^-m)/(√2 i), so R_y(90°) is
//
//   d_{m'm} ± (-1)^m d_{m',-m} = d_{m'm} (1 ± (-1)^(l+m+m'))      + between cosines, - between sines,
//
// by d_{m',-m}(90°) = (-1)^(l+m') d_{m'm}(90°): twice d, or nothing. Finally d_{m'm} = (-1)^(l-m) B_{l-m',l-m}, because
// the spinor matrix of R_y(90°), [[1, -1], [1, 1]]/√2, is that of the half turn times diag(1, -1). Collecting the signs
// gives the formula above.
pub(crate) struct YzExchange {
    bands: Vec<YzExchangeBand>,
}

/// The blocks of `J_l` that do not vanish. Lists of coefficients are sorted as in [`SplitBand`].
pub(crate) struct YzExchangeBand {
    /// Cosines to cosines: of even `m` if `l` is even, of odd `m` if `l` is odd.
    cos_from_cos: Block,
    /// Sines to sines: of odd `m` if `l` is even, of even `m` if `l` is odd.
    sin_from_sin: Block,
    /// The other sines from the other cosines.
    sin_from_cos: Block,
    /// The other cosines from the other sines.
    cos_from_sin: Block,
}

/// The coefficients of one band, sorted: `cos_even` holds m = 0, 2, 4 .., `cos_odd` m = 1, 3 .., `sin_even`
/// m = -2, -4 .. and `sin_odd` m = -1, -3 ... Each list may be longer than needed by up to `LANES` places.
pub(crate) struct SplitBand<'a, T> {
    pub(crate) cos_even: &'a mut [T],
    pub(crate) sin_even: &'a mut [T],
    pub(crate) cos_odd: &'a mut [T],
    pub(crate) sin_odd: &'a mut [T],
}

impl<'a, T: Coefficient> SplitBand<'a, T> {
    /// The places that the lists of orders up to `order` need together.
    pub(crate) const fn places(order: usize) -> usize {
        4 * Self::list_places(order)
    }

    const fn list_places(order: usize) -> usize {
        (order / 2 + 1).next_multiple_of(LANES)
    }

    /// Empty lists in `work`, which has `places(order)` places.
    pub(crate) fn new(order: usize, work: &'a mut [T]) -> Self {
        let places = Self::list_places(order);
        let (cos_even, work) = work.split_at_mut(places);
        let (sin_even, work) = work.split_at_mut(places);
        let (cos_odd, sin_odd) = work.split_at_mut(places);
        Self { cos_even, sin_even, cos_odd, sin_odd }
    }

    /// Sorts the coefficients of band `l` into the lists.
    #[inline(always)]
    pub(crate) fn load(&mut self, l: usize, band: &[T]) {
        let band = &band[..2 * l + 1];
        self.cos_even[0] = band[l];
        for k in 1..=l / 2 {
            self.cos_even[k] = band[l + 2 * k];
            self.sin_even[k - 1] = band[l - 2 * k];
        }
        for k in 0..l.div_ceil(2) {
            self.cos_odd[k] = band[l + 2 * k + 1];
            self.sin_odd[k] = band[l - 2 * k - 1];
        }
    }

    /// Puts the lists back in index order.
    #[inline(always)]
    pub(crate) fn store(&self, l: usize, band: &mut [T]) {
        let band = &mut band[..2 * l + 1];
        band[l] = self.cos_even[0];
        for k in 1..=l / 2 {
            band[l + 2 * k] = self.cos_even[k];
            band[l - 2 * k] = self.sin_even[k - 1];
        }
        for k in 0..l.div_ceil(2) {
            band[l + 2 * k + 1] = self.cos_odd[k];
            band[l - 2 * k - 1] = self.sin_odd[k];
        }
    }
}

impl YzExchange {
    /// Calls `f` with the table of the bands below [`FIRST_HIGH_BAND`] (0.7 MB), shared by the whole process.
    pub(crate) fn with_shared<R>(f: impl FnOnce(&Self) -> R) -> R {
        static SHARED: Once<YzExchange> = Once::new();
        f(SHARED.get_or_init(|| Self::new(FIRST_HIGH_BAND)))
    }

    pub(crate) fn new(order: usize) -> Self {
        let mut wigner = WignerHalfPi::new(order);
        let bands = (0..order)
            .map(|l| {
                let band = YzExchangeBand::new(l, &wigner);
                wigner.advance();
                wigner.advance();
                band
            })
            .collect();
        Self { bands }
    }

    pub(crate) fn band(&self, l: usize) -> &YzExchangeBand {
        &self.bands[l]
    }
}

impl YzExchangeBand {
    fn new(l: usize, wigner: &WignerHalfPi) -> Self {
        // |m| of place k of the four lists, and their lengths.
        let (even, odd, sin_even) = (|k: usize| 2 * k, |k: usize| 2 * k + 1, |k: usize| 2 * k + 2);
        let (evens, odds, sin_evens) = (l / 2 + 1, l.div_ceil(2), l / 2);
        let entry = |row: usize, column: usize| entry(l, row, column, wigner);
        if l.is_multiple_of(2) {
            Self {
                cos_from_cos: Block::new(evens, evens, |r, c| entry(even(r), even(c))),
                sin_from_sin: Block::new(odds, odds, |r, c| entry(odd(r), odd(c))),
                sin_from_cos: Block::new(sin_evens, odds, |r, c| entry(sin_even(r), odd(c))),
                cos_from_sin: Block::new(odds, sin_evens, |r, c| entry(odd(r), sin_even(c))),
            }
        } else {
            Self {
                cos_from_cos: Block::new(odds, odds, |r, c| entry(odd(r), odd(c))),
                sin_from_sin: Block::new(sin_evens, sin_evens, |r, c| entry(sin_even(r), sin_even(c))),
                sin_from_cos: Block::new(odds, evens, |r, c| entry(odd(r), even(c))),
                cos_from_sin: Block::new(evens, odds, |r, c| entry(even(r), odd(c))),
            }
        }
    }

    /// `to = J_l from`. All sizes follow from `l`, so that a caller with a constant `l` gets loops of constant length.
    #[inline(always)]
    pub(crate) fn apply<T: Coefficient>(&self, l: usize, from: &SplitBand<'_, T>, to: &mut SplitBand<'_, T>) {
        let (evens, odds, sin_evens) = (l / 2 + 1, l.div_ceil(2), l / 2);
        if l.is_multiple_of(2) {
            self.cos_from_cos.apply(evens, evens, from.cos_even, to.cos_even);
            self.sin_from_sin.apply(odds, odds, from.sin_odd, to.sin_odd);
            self.sin_from_cos.apply(sin_evens, odds, from.cos_odd, to.sin_even);
            self.cos_from_sin.apply(odds, sin_evens, from.sin_even, to.cos_odd);
        } else {
            self.cos_from_cos.apply(odds, odds, from.cos_odd, to.cos_odd);
            self.sin_from_sin.apply(sin_evens, sin_evens, from.sin_even, to.sin_even);
            self.sin_from_cos.apply(odds, evens, from.cos_even, to.sin_odd);
            self.cos_from_sin.apply(evens, odds, from.sin_odd, to.cos_even);
        }
    }

    /// The entries that do not vanish by symmetry.
    #[cfg(test)]
    fn entries(&self) -> impl Iterator<Item = f64> + '_ {
        [&self.cos_from_cos, &self.sin_from_sin, &self.sin_from_cos, &self.cos_from_sin].into_iter().flat_map(|block| {
            (0..block.rows).flat_map(|r| (0..block.columns).map(move |c| (r, c))).map(|(r, c)| block.get(r, c))
        })
    }
}

/// The entry of `J_l` for the absolute values `row` and `column` of `m'` and `m`, see [`YzExchange`].
fn entry(l: usize, row: usize, column: usize, wigner: &WignerHalfPi) -> f64 {
    let exponent = row / 2 + column / 2 + l * (row + column);
    let sign = if exponent.is_multiple_of(2) { 1.0 } else { -1.0 };
    let weight = |m: usize| if m == 0 { 1.0 } else { SQRT_2 };
    sign * weight(row) * weight(column) * wigner.get(l - row, l - column)
}

/// A dense matrix, stored in strips of `LANES` rows, column after column; the last strip is filled up with zeros.
struct Block {
    rows: usize,
    columns: usize,
    strips: Vec<[f64; LANES]>,
}

impl Block {
    fn new(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let mut strips = Vec::with_capacity(rows.div_ceil(LANES) * columns);
        for first in (0..rows).step_by(LANES) {
            for column in 0..columns {
                strips.push(core::array::from_fn(|k| if first + k < rows { entry(first + k, column) } else { 0.0 }));
            }
        }
        Self { rows, columns, strips }
    }

    /// `to = M from`; `to` has places for whole strips.
    #[inline(always)]
    fn apply<T: Coefficient>(&self, rows: usize, columns: usize, from: &[T], to: &mut [T]) {
        debug_assert!((rows, columns) == (self.rows, self.columns), "the size follows from the band");
        let from = &from[..columns];
        for strip in 0..rows.div_ceil(LANES) {
            let mut sum = [T::ZERO; LANES];
            for (entries, x) in self.strips[strip * columns..][..columns].iter().zip(from) {
                for (sum, entry) in sum.iter_mut().zip(entries) {
                    *sum += x.scale(T::Scalar::from_f64(*entry));
                }
            }
            to[strip * LANES..][..LANES].copy_from_slice(&sum);
        }
    }

    #[cfg(test)]
    fn get(&self, row: usize, column: usize) -> f64 {
        self.strips[row / LANES * self.columns + column][row % LANES]
    }
}

/// Exchanges y and z: the coefficients of `g(x, y, z) = f(x, z, y)`.
pub(crate) fn exchange_yz_in_place<T: Coefficient>(coefficients: &mut [T]) {
    exchange_high_bands(coefficients);
    let order = order_of_slice(coefficients).min(FIRST_HIGH_BAND);
    let mut work = vec![T::ZERO; 2 * SplitBand::<T>::places(order)];
    let (from, to) = work.split_at_mut(SplitBand::<T>::places(order));
    let (mut from, mut to) = (SplitBand::new(order, from), SplitBand::new(order, to));
    YzExchange::with_shared(|table| {
        for l in 0..order {
            let band = &mut coefficients[band_range(l)];
            from.load(l, band);
            table.band(l).apply(l, &from, &mut to);
            to.store(l, band);
        }
    });
}

/// Wigner's matrix of the half turn that exchanges `+x` and `+z`, on spinors of `N` indices: for `N = 2l` that is
/// `d^l(π/2)` but for signs, see [`YzExchange`].
///
/// ```text
///   e_k = √(N over k) u^(N-k) v^k        u → (u + v)/√2        v → (u - v)/√2        e_k → Σ_k' B_{k'k}^N e_k'
///
///   B_{k'k}^{N+1} = { √(N+1-k') [ √(N+1-k) B_{k'k}   + √k B_{k',k-1}   ]
///                   + √k'       [ √(N+1-k) B_{k'-1,k} - √k B_{k'-1,k-1} ] } / (√2 (N+1))
/// ```
///
/// with `B^N` on the right. Each step expresses `e_k^{N+1} = √((N+1-k)/(N+1)) u e_k^N + √(k/(N+1)) v e_{k-1}^N`: it
/// adds one spinor index and symmetrizes. The squares of the weights sum to 1 and nothing divides by a small number, so
/// that errors do not grow ([Risbo 1996], for any angle). `B` is symmetric. The test
/// `the_half_turn_has_the_exact_values_of_krawtchouk` finds every entry to order 60 within 1e-14 of exact integers.
///
/// [Risbo 1996]: https://doi.org/10.1007/BF01090814
pub(crate) struct WignerHalfPi {
    /// Entries are stored for `k < size` only: no step needs a higher one.
    size: usize,
    n: usize,
    matrix: Vec<f64>,
}

impl WignerHalfPi {
    /// `B^0`.
    pub(crate) fn new(size: usize) -> Self {
        let mut matrix = vec![0.0; size * size];
        if let Some(first) = matrix.first_mut() {
            *first = 1.0;
        }
        Self { size, n: 0, matrix }
    }

    pub(crate) fn get(&self, row: usize, column: usize) -> f64 {
        self.matrix[row * self.size + column]
    }

    /// From `B^N` to `B^{N+1}`, in place from the last entry backwards.
    pub(crate) fn advance(&mut self) {
        let n = self.n + 1;
        let scale = 1.0 / (SQRT_2 * n as f64);
        let root: Vec<f64> = (0..=n).map(|k| (k as f64).sqrt()).collect();
        let last = n.min(self.size - 1);
        for row in (0..=last).rev() {
            for column in (0..=last).rev() {
                let left = |row: usize| if column > 0 { root[column] * self.get(row, column - 1) } else { 0.0 };
                let upper = root[n - row] * (root[n - column] * self.get(row, column) + left(row));
                let lower = if row > 0 {
                    root[row] * (root[n - column] * self.get(row - 1, column) - left(row - 1))
                } else {
                    0.0
                };
                self.matrix[row * self.size + column] = scale * (upper + lower);
            }
        }
        self.n = n;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::{Expansion as _, ShVec};
    use crate::sphere::Dir;

    /// Two sums of 64 terms of size 1 at most, a hundred roundings each.
    const ORDER_64: f64 = 1e-13;

    fn random(order: usize) -> ShVec<f64> {
        ShVec::from_vec(lobe_testkit::Random::new(5).signed_vec(order * order)).unwrap()
    }

    #[test]
    fn the_exchange_swaps_y_and_z_of_the_direction() {
        for order in [1, 2, 3, 4, 5, 17, 64, 66, 129, 256] {
            let f = random(order);
            let mut g = f.clone();
            exchange_yz_in_place(g.coefficients_mut());
            let scale = f.dot(&f).sqrt() * order as f64;
            for [x, y, z] in lobe_testkit::directions() {
                let (got, expected) = (g.eval(Dir::from_unit([x, y, z])), f.eval(Dir::from_unit([x, z, y])));
                assert!((got - expected).abs() < 1e-14 * scale, "order {order}: {got} against {expected}");
            }
        }
    }

    #[test]
    fn the_exchange_is_its_own_inverse() {
        let f = random(FIRST_HIGH_BAND);
        let mut g = f.clone();
        exchange_yz_in_place(g.coefficients_mut());
        exchange_yz_in_place(g.coefficients_mut());
        for (i, (a, b)) in f.coefficients().iter().zip(g.coefficients()).enumerate() {
            assert!((a - b).abs() < ORDER_64, "coefficient {i}: {a} became {b}");
        }
    }

    #[test]
    fn the_exchange_is_symmetric() {
        let table = YzExchange::new(FIRST_HIGH_BAND);
        for l in 0..FIRST_HIGH_BAND {
            let band = table.band(l);
            for (a, b) in [
                (&band.cos_from_cos, &band.cos_from_cos),
                (&band.sin_from_sin, &band.sin_from_sin),
                (&band.sin_from_cos, &band.cos_from_sin),
            ] {
                for row in 0..a.rows {
                    for column in 0..a.columns {
                        let (a, b) = (a.get(row, column), b.get(column, row));
                        assert!((a - b).abs() < ORDER_64, "band {l}, ({row}, {column}): {a} against {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_exchange_has_the_known_values_and_zeros() {
        let table = YzExchange::new(6);
        let distinct = |l: usize| {
            let mut values: Vec<f64> = table.band(l).entries().map(f64::abs).collect();
            values.sort_by(f64::total_cmp);
            values.dedup_by(|a, b| (*a - *b).abs() < 1e-14);
            values
        };
        for (l, expected) in [
            (2, &[0.5, 0.75_f64.sqrt(), 1.0][..]),
            (3, &[0.25, 0.375_f64.sqrt(), 0.625_f64.sqrt(), 15.0_f64.sqrt() / 4.0, 1.0][..]),
        ] {
            let found = distinct(l);
            let same = found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14);
            assert!(same, "band {l}: {found:?} against {expected:?}");
        }
        let counts: Vec<usize> = (0..6).map(|l| table.band(l).entries().count()).collect();
        assert_eq!(counts, [1, 3, 7, 13, 21, 31], "entries that do not vanish by symmetry");
    }

    #[test]
    fn three_z_rotations_and_two_exchanges_take_few_multiplications() {
        let table = YzExchange::new(6);
        let mut total = 0;
        let mut cumulative = Vec::new();
        for l in 0..6 {
            let exchanges = table.band(l).entries().filter(|e| (e.abs() - 1.0).abs() > 1e-14).count();
            total += 3 * 4 * l + 2 * exchanges;
            cumulative.push(total);
        }
        assert_eq!(cumulative, [0, 12, 44, 104, 194, 316], "multiplications of bands 0 to l");
    }

    // Σ_j (-1)^j (x over j)(N-x over k-j), the coefficient of u^(N-k) v^k in (u + v)^(N-x) (u - v)^x.
    #[test]
    fn the_half_turn_has_the_exact_values_of_krawtchouk() {
        const N: usize = 118;
        let binomial = |n: usize, k: usize| (0..k).fold(1_i128, |b, j| b * (n - j) as i128 / (j + 1) as i128);
        let mut half_turn = WignerHalfPi::new(N / 2 + 1);
        for _ in 0..N {
            half_turn.advance();
        }
        for x in 0..=N / 2 {
            let mut polynomial = vec![0_i128; N + 1];
            polynomial[0] = 1;
            for factor in 0..N {
                let sign = if factor < x { -1 } else { 1 };
                for k in (1..=N).rev() {
                    polynomial[k] += sign * polynomial[k - 1];
                }
            }
            for k in 0..=N / 2 {
                // B_kx = √(N over x) / √(N over k) 2^(-N/2) K
                let root = (binomial(N, x) as f64 / binomial(N, k) as f64).sqrt();
                let exact = polynomial[k] as f64 * root * 2.0_f64.powi(-(N as i32) / 2);
                let found = half_turn.get(k, x);
                assert!((found - exact).abs() < 1e-14, "({k}, {x}): {found} against {exact}");
            }
        }
    }
}
