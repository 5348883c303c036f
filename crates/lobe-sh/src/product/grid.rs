//! Products of any number of functions, multiplied point by point on a quadrature grid.

use core::f64::consts::PI;

use crate::basis::basis::Basis;
use crate::basis::index::{coefficient_count, coefficient_index, order_of_slice};
use crate::expansion::ShVec;
use crate::prelude::*;
#[cfg(feature = "fft")]
use crate::product::grid_fft::product_by_fft;
use crate::scalar::Coefficient;
use crate::sphere::quadrature::SphereQuadrature;

/// The product of any number of functions of any orders, cut off at `order` once, at the end.
///
/// ```text
///   c_i = ∫ f_1 f_2 .. f_k y_i ds
/// ```
///
/// Exact up to rounding, in `f64` whatever the type of the coefficients, colors channel by channel: every factor is evaluated at the points of
/// a rule whose degree is that of the integrand, `D = Σ (n_k - 1) + (order - 1)`, where the values are multiplied and
/// projected. Unlike a chain of products that are cut off one by one it does not depend on the order of the factors
/// (test `a_chain_of_truncated_products_differs_from_the_grid`). The product of no factors is the constant 1.
///
/// Rows of equal `z` are transformed on their own, those at `z` and `-z` together, whose bands differ in signs alone, and of
/// each row the points at `φ` and `-φ`, where cosines are equal and sines opposite. With `J = ⌊D/2⌋ + 1` rows of `K = D + 1`
/// points the cost is about `J (n²/2 + nK)` multiplications for each factor of order `n` and as many for the result; with the
/// feature `fft` `J (n²/2 + K log K)`, by FFT, from a degree of 24 on. It grows with `n³` and with the square of the number of factors.
///
/// # Panics
/// If the length of a factor is no perfect square.
#[must_use]
pub fn product_on_grid<T: Coefficient>(factors: &[&[T]], order: usize) -> ShVec<T> {
    let orders: Vec<usize> = factors.iter().map(|f| order_of_slice(f)).collect();
    if order == 0 || orders.contains(&0) {
        return ShVec::zero(order);
    }
    let degree = orders.iter().map(|n| n - 1).sum::<usize>() + order - 1;
    let highest = orders.iter().copied().fold(order, usize::max);
    let channel = |c: usize| factors.iter().map(|f| f.iter().map(|f| f.widen().channel(c)).collect()).collect();
    let channels: Vec<Vec<Vec<f64>>> = (0..T::CHANNELS).map(channel).collect();
    let sums = channel_products(&channels, order, [degree, highest]);
    let coefficient = |i: usize| T::narrow(T::Wide::from_channels(|c| sums[c][i]));
    ShVec::of((0..coefficient_count(order)).map(coefficient).collect())
}

/// The degree of the integrand from which on rows are transformed by FFT.
#[cfg(feature = "fft")]
const FIRST_FFT_DEGREE: usize = 24;

/// The product of the factors of every channel. Not generic, so that it is compiled once.
fn channel_products(channels: &[Vec<Vec<f64>>], order: usize, [degree, highest]: [usize; 2]) -> Vec<Vec<f64>> {
    #[cfg(feature = "fft")]
    if degree >= FIRST_FFT_DEGREE {
        return channels.iter().map(|factors| product_by_fft(factors, order, [degree, highest])).collect();
    }
    direct(channels, order, [degree, highest])
}

/// Row by row with the sums of each `m`, in plain code.
fn direct(channels: &[Vec<Vec<f64>>], order: usize, [degree, highest]: [usize; 2]) -> Vec<Vec<f64>> {
    let grid = RowGrid::new(degree, highest);
    let turns = HalfTurns::new(&grid);
    let mut sums = vec![vec![0.0; coefficient_count(order)]; channels.len()];
    let mut theta = vec![0.0; coefficient_count(grid.order)];
    let [mut values, mut product] = [(); 2].map(|()| [(); 2].map(|()| Row::new(turns.count)));
    let rows = grid.rule.rows();
    for (j, &(z, weight)) in rows.iter().enumerate().skip(rows.len() / 2) {
        grid.theta_into(z, &mut theta);
        let weight = weight * 2.0 * PI / grid.azimuths as f64;
        // The row in the middle is its own mirror image, and counts once.
        let mirrored = if 2 * j + 1 == rows.len() { 0.0 } else { weight };
        for (factors, sum) in channels.iter().zip(&mut sums) {
            for (product, weight) in product.iter_mut().zip([weight, mirrored]) {
                product.fill_with_weights(weight, grid.azimuths);
            }
            for factor in factors {
                turns.evaluate_rows(factor, &theta, &mut values);
                for (product, values) in product.iter_mut().zip(&values) {
                    product.multiply_by(values);
                }
            }
            turns.project_rows(&product, &theta, sum);
        }
    }
    sums
}

/// A Gauss-Legendre × uniform rule with transforms of single rows between coefficients and values.
pub(crate) struct RowGrid {
    pub(crate) rule: SphereQuadrature,
    pub(crate) azimuths: usize,
    /// The highest order that rows are transformed at.
    order: usize,
    /// `cos(2π k/K)` and `sin(2π k/K)`.
    turns: Vec<(f64, f64)>,
}

impl RowGrid {
    /// The rule for integrands of `degree`, for expansions up to `order`.
    pub(crate) fn new(degree: usize, order: usize) -> Self {
        let rule = SphereQuadrature::of_degree(degree);
        let azimuths = rule.azimuths();
        let turn = |k: usize| (2.0 * PI * k as f64 / azimuths as f64).sin_cos();
        let turns = (0..azimuths).map(turn).map(|(sin, cos)| (cos, sin)).collect();
        Self { rule, azimuths, order, turns }
    }

    /// `y_lm(z, φ = 0)` for `m >= 0`, the part of the basis that depends on `z`. Same index as the basis.
    pub(crate) fn theta_into(&self, z: f64, theta: &mut [f64]) {
        let r = ((1.0 - z) * (1.0 + z)).sqrt();
        Basis::<f64>::with_shared(self.order, |basis| basis.eval_into([r, 0.0, z], theta));
    }

    /// `cos mφ` and `sin mφ` at azimuth `k`.
    pub(crate) fn turn(&self, m: usize, k: usize) -> (f64, f64) {
        self.turns[m * k % self.azimuths]
    }
}

/// The values of a row at the azimuths `φ_k = 2π k/K` of a half turn, `0 <= φ <= π`, and of the other half by symmetry:
/// `f(φ) = e + o` and `f(-φ) = e - o`.
struct Row {
    even: Vec<f64>,
    odd: Vec<f64>,
}

impl Row {
    fn new(count: usize) -> Self {
        Self { even: vec![0.0; count], odd: vec![0.0; count] }
    }

    /// A weight for each point: two of them are at `φ` and `-φ`, one at 0 and at π.
    fn fill_with_weights(&mut self, weight: f64, azimuths: usize) {
        self.odd.fill(0.0);
        for (k, even) in self.even.iter_mut().enumerate() {
            let is_alone = k == 0 || 2 * k == azimuths;
            *even = if is_alone { weight } else { 2.0 * weight };
        }
    }

    /// `(e + o) (e' + o') = (e e' + o o') + (e o' + o e')`, of which the first part is even.
    fn multiply_by(&mut self, other: &Self) {
        let (even, odd) = (self.even.iter_mut().zip(&other.even), self.odd.iter_mut().zip(&other.odd));
        for ((e, other_e), (o, other_o)) in even.zip(odd) {
            (*e, *o) = (*e * *other_e + *o * *other_o, *e * *other_o + *o * *other_e);
        }
    }
}

/// `cos mφ_k` and `sin mφ_k` at the azimuths of a half turn, those of each `m` one after the other.
struct HalfTurns {
    cos: Vec<f64>,
    sin: Vec<f64>,
    /// Azimuths.
    count: usize,
}

/// What the mirrored row makes of bands whose `l - m` is odd.
const SIGNS: [f64; 2] = [1.0, -1.0];

impl HalfTurns {
    fn new(grid: &RowGrid) -> Self {
        let count = grid.azimuths / 2 + 1;
        let (mut cos, mut sin) = (Vec::with_capacity(grid.order * count), Vec::with_capacity(grid.order * count));
        for m in 0..grid.order {
            // The angle as a part of K, without a division for each point.
            let mut at = 0;
            for _ in 0..count {
                let (c, s) = grid.turns[at];
                cos.push(c);
                sin.push(s);
                at += m;
                if at >= grid.azimuths {
                    at -= grid.azimuths;
                }
            }
        }
        Self { cos, sin, count }
    }

    fn of(&self, m: usize) -> (&[f64], &[f64]) {
        let range = m * self.count..(m + 1) * self.count;
        (&self.cos[range.clone()], &self.sin[range])
    }

    /// The values along the rows at `z` and `-z`: for every `m` the sum over bands, then the Fourier series.
    fn evaluate_rows(&self, f: &[f64], theta: &[f64], rows: &mut [Row; 2]) {
        let order = order_of_slice(f);
        for row in rows.iter_mut() {
            row.even.fill(0.0);
            row.odd.fill(0.0);
        }
        for m in 0..order {
            // Bands whose l - m is even, and odd.
            let (mut cos, mut sin) = ([0.0; 2], [0.0; 2]);
            for l in m..order {
                let y = theta[coefficient_index(l, m as isize)];
                cos[(l - m) % 2] += f[coefficient_index(l, m as isize)] * y;
                sin[(l - m) % 2] += f[coefficient_index(l, -(m as isize))] * y;
            }
            let turns = self.of(m);
            for (row, sign) in rows.iter_mut().zip(SIGNS) {
                let (cos, sin) = (cos[0] + cos[1] * sign, sin[0] + sin[1] * sign);
                for (value, turn) in row.even.iter_mut().zip(turns.0) {
                    *value += cos * turn;
                }
                // Of m = 0 all sines are zero.
                for (value, turn) in row.odd.iter_mut().zip(turns.1) {
                    *value += sin * turn;
                }
            }
        }
    }

    /// Adds what the rows at `z` and `-z` contribute to the coefficients: the Fourier sums, then every band.
    fn project_rows(&self, rows: &[Row; 2], theta: &[f64], sum: &mut [f64]) {
        let order = order_of_slice(sum);
        for m in 0..order {
            let turns = self.of(m);
            let cos = rows.each_ref().map(|row| scaled_sum(&row.even, turns.0));
            let sin = rows.each_ref().map(|row| scaled_sum(&row.odd, turns.1));
            // For bands whose l - m is even, and odd.
            let [cos, sin] = [cos, sin].map(|[up, down]| SIGNS.map(|sign| up + down * sign));
            for l in m..order {
                let y = theta[coefficient_index(l, m as isize)];
                sum[coefficient_index(l, m as isize)] += cos[(l - m) % 2] * y;
                if m > 0 {
                    sum[coefficient_index(l, -(m as isize))] += sin[(l - m) % 2] * y;
                }
            }
        }
    }
}

/// `Σ_k v_k t_k`, in sums side by side: one after the other each would wait for the last.
fn scaled_sum(values: &[f64], turns: &[f64]) -> f64 {
    const SUMS: usize = 8;
    let ((values, last_values), (turns, last_turns)) = (values.as_chunks::<SUMS>(), turns.as_chunks::<SUMS>());
    let mut sums = [0.0; SUMS];
    for (values, turns) in values.iter().zip(turns) {
        for ((sum, value), turn) in sums.iter_mut().zip(values).zip(turns) {
            *sum += value * turn;
        }
    }
    let mut all = 0.0;
    for sum in sums {
        all += sum;
    }
    for (value, turn) in last_values.iter().zip(last_turns) {
        all += value * turn;
    }
    all
}

#[cfg(all(test, feature = "fft"))]
mod tests {
    use lobe_testkit::Random;

    use super::*;

    #[test]
    fn the_transforms_by_fft_are_those_of_each_wave() {
        // Numbers of rows that are odd and even, one factor and three, and orders below those of the factors.
        let cases: [(&[usize], usize); 6] =
            [(&[4], 4), (&[13, 13], 25), (&[16, 9], 20), (&[2, 3, 30], 7), (&[40, 40], 79), (&[1, 1], 1)];
        for (orders, order) in cases {
            let mut random = Random::new(order as u64);
            let factors: Vec<Vec<f64>> = orders.iter().map(|n| random.signed_vec(n * n)).collect();
            let degree = orders.iter().map(|n| n - 1).sum::<usize>() + order - 1;
            let sizes = [degree, orders.iter().copied().fold(order, usize::max)];
            let found = product_by_fft(&factors, order, sizes);
            let expected = direct(&[factors], order, sizes).remove(0);
            let largest = expected.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
            for (i, (a, b)) in found.iter().zip(expected).enumerate() {
                let error = (a - b).abs();
                assert!(error < 1e-14 * order as f64 * largest, "{orders:?} at {order}, c_{i}: {a} against {b}");
            }
        }
    }
}
