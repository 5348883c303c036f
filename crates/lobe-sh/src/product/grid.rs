//! Products of any number of functions, multiplied point by point on a quadrature grid.

use core::f64::consts::PI;

use crate::basis::index::{coefficient_count, coefficient_index, order_of_slice};
use crate::prelude::*;
use crate::{Basis, Coefficient, ShVec, SphereQuadrature};

/// The product of any number of functions of any orders, cut off at `order` once, at the end.
///
/// ```text
///   c_i = ∫ f_1 f_2 .. f_k y_i ds
/// ```
///
/// Exact up to rounding, in `f64` whatever the type of the coefficients: every factor is evaluated at the points of
/// a rule whose degree is that of the integrand, `D = Σ (n_k - 1) + (order - 1)`, where the values are multiplied and
/// projected. Unlike a chain of products that are cut off one by one it does not depend on the order of the factors
/// (test `a_chain_of_truncated_products_differs_from_the_grid`). The product of no factors is the constant 1.
///
/// Rows of equal `z` are transformed on their own, so that with `J = ⌊D/2⌋ + 1` rows of `K = D + 1` points the cost
/// is about `J (n² + 2nK)` multiplications for each factor of order `n` and as many for the result, which grows with
/// `n³` and with the square of the number of factors.
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
    let grid = RowGrid::new(degree, orders.iter().copied().fold(order, usize::max));
    let mut sum = vec![T::Wide::ZERO; coefficient_count(order)];
    let mut theta = vec![0.0; coefficient_count(grid.order)];
    let (mut values, mut product) = (vec![T::Wide::ZERO; grid.azimuths], vec![T::Wide::ZERO; grid.azimuths]);
    for &(z, weight) in grid.rule.rows() {
        grid.theta_into(z, &mut theta);
        product.fill(T::Wide::splat(weight * 2.0 * PI / grid.azimuths as f64));
        for factor in factors {
            grid.evaluate_row(factor, &theta, &mut values);
            for (product, value) in product.iter_mut().zip(&values) {
                *product = *product * *value;
            }
        }
        grid.project_row(&product, &theta, &mut sum);
    }
    let mut out = ShVec::zero(order);
    for (out, sum) in crate::Expansion::coefficients_mut(&mut out).iter_mut().zip(sum) {
        *out = T::narrow(sum);
    }
    out
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

    /// The values along a row: for every `m` the sum over bands, then the Fourier series.
    fn evaluate_row<T: Coefficient>(&self, f: &[T], theta: &[f64], values: &mut [T::Wide]) {
        let order = order_of_slice(f);
        values.fill(T::Wide::ZERO);
        for m in 0..order {
            let (mut cos, mut sin) = (T::Wide::ZERO, T::Wide::ZERO);
            for l in m..order {
                let y = theta[coefficient_index(l, m as isize)];
                cos += f[coefficient_index(l, m as isize)].widen().scale(y);
                sin += f[coefficient_index(l, -(m as isize))].widen().scale(y);
            }
            if m == 0 {
                sin = T::Wide::ZERO;
            }
            for (k, value) in values.iter_mut().enumerate() {
                let (c, s) = self.turn(m, k);
                *value += cos.scale(c) + sin.scale(s);
            }
        }
    }

    /// Adds what a row contributes to the coefficients: the Fourier sums, then every band.
    fn project_row<W: Coefficient<Scalar = f64>>(&self, values: &[W], theta: &[f64], sum: &mut [W]) {
        let order = order_of_slice(sum);
        for m in 0..order {
            let (mut cos, mut sin) = (W::ZERO, W::ZERO);
            for (k, value) in values.iter().enumerate() {
                let (c, s) = self.turn(m, k);
                cos += value.scale(c);
                sin += value.scale(s);
            }
            for l in m..order {
                let y = theta[coefficient_index(l, m as isize)];
                sum[coefficient_index(l, m as isize)] += cos.scale(y);
                if m > 0 {
                    sum[coefficient_index(l, -(m as isize))] += sin.scale(y);
                }
            }
        }
    }
}
