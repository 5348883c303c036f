//! Multiplication by a fixed function as a matrix.

use core::f64::consts::PI;

use crate::basis::index::band_and_m;
use crate::basis::index::{coefficient_count, coefficient_index, order_of_slice};
use crate::expansion::Expansion;
use crate::prelude::*;
use crate::product::gaunt::{GauntTensor, MAX_GAUNT_ORDER};
use crate::product::grid::RowGrid;
use crate::scalar::{Coefficient, Real};
use crate::sphere::Dir;

/// Multiplication by a fixed function `f`, cut off at an order, as a symmetric matrix.
///
/// ```text
///   M_ij = ∫ f y_i y_j ds = Σ_k Γ_ijk f_k        (f g)_i = Σ_j M_ij g_j
/// ```
///
/// With a visibility or shadow function for `f` it is the transfer matrix of [Green 2003], which turns light into
/// shadowed light. `f` has one channel; a colored function has one matrix for each. The matrix may be applied to
/// colors.
///
/// `M` depends on `f` up to band `2n - 2` for order `n`; higher bands have no Gaunt coefficients with two functions of
/// that order. To apply it costs `n⁴` multiplications and additions, fewer than [`product_into`](crate::product::product_into)
/// from order 5 on, so it pays where one function multiplies many.
///
/// ```
/// use lobe_sh::product::ProductMatrix;
/// use lobe_sh::{Dir, Expansion as _, ShL1, ShVec};
///
/// let f = ShL1::<f64>::impulse(Dir::Z, 1.0);
/// let g = ShL1::<f64>::constant(2.0);
/// let mut fg = ShL1::zero();
/// ProductMatrix::new(&f, 2).apply_into(g.coefficients(), fg.coefficients_mut());
/// assert!((fg.eval(Dir::Z) - 2.0 * f.eval(Dir::Z)).abs() < 1e-14);
/// ```
///
/// [Green 2003]: https://3dvar.com/Green2003Spherical.pdf
#[derive(Clone, Debug, PartialEq)]
pub struct ProductMatrix<S> {
    order: usize,
    entries: Vec<S>,
}

impl<S: Real> ProductMatrix<S> {
    /// The matrix of an expansion of any order, for functions and products of order `order`. Exact up to rounding.
    ///
    /// From the [`GauntTensor`], with exact zeros, up to order [`MAX_GAUNT_ORDER`]; above, by quadrature.
    #[must_use]
    pub fn new(f: &impl Expansion<S>, order: usize) -> Self {
        // Bands from 2n - 1 on have no Gaunt coefficients with two functions of order n.
        let used = f.order().min((2 * order).saturating_sub(1));
        let f: Vec<f64> = f.coefficients()[..coefficient_count(used)].iter().map(|c| c.to_f64()).collect();
        if used.max(order) > MAX_GAUNT_ORDER {
            let f = crate::ShVec::of(f);
            return Self::from_fn(order, used.saturating_sub(1), |s| f.eval(s));
        }
        let mut entries = vec![0.0; coefficient_count(order) * coefficient_count(order)];
        for t in GauntTensor::new(order, order, used).coefficients() {
            entries[t.i * coefficient_count(order) + t.j] += t.value * f[t.k];
        }
        Self::from_f64(order, &entries)
    }

    /// The matrix of a function given by its values: exact up to rounding if `f` is a spherical polynomial of at most
    /// `degree`, else an approximation that a higher `degree` improves.
    ///
    /// With `D = degree + 2 (order - 1)`, `f` is evaluated at about `D²/2` points, and `order⁴ D/2` multiplications
    /// follow.
    #[must_use]
    pub fn from_fn(order: usize, degree: usize, mut f: impl FnMut(Dir) -> f64) -> Self {
        let n = coefficient_count(order);
        let mut entries = vec![0.0; n * n];
        if order == 0 {
            return Self::from_f64(order, &entries);
        }
        let grid = RowGrid::new(degree + 2 * (order - 1), order);
        let mut theta = vec![0.0; n];
        for &(z, weight) in grid.rule.rows() {
            grid.theta_into(z, &mut theta);
            let series = row_series(&grid, z, weight, 2 * order - 1, &mut f);
            for i in 0..n {
                let (l, m_i) = band_and_m(i);
                let y_i = theta[coefficient_index(l, m_i.abs())];
                for j in 0..=i {
                    let (l, m_j) = band_and_m(j);
                    entries[i * n + j] += y_i * theta[coefficient_index(l, m_j.abs())] * azimuthal(&series, m_i, m_j);
                }
            }
        }
        for i in 0..n {
            for j in 0..i {
                entries[j * n + i] = entries[i * n + j];
            }
        }
        Self::from_f64(order, &entries)
    }

    fn from_f64(order: usize, entries: &[f64]) -> Self {
        Self { order, entries: entries.iter().map(|&m| S::from_f64(m)).collect() }
    }

    /// The order of the functions that are multiplied and of the product.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The entries, row after row; `M_ij = M_ji`.
    #[must_use]
    pub fn entries(&self) -> &[S] {
        &self.entries
    }

    /// `M_ij`.
    ///
    /// # Panics
    /// If `i` or `j` is not below `order²`.
    #[must_use]
    pub fn entry(&self, i: usize, j: usize) -> S {
        assert!(
            i < coefficient_count(self.order) && j < coefficient_count(self.order),
            "no entry ({i}, {j}) at order {}",
            self.order
        );
        self.entries[i * coefficient_count(self.order) + j]
    }

    /// The product of `f` and `g`.
    ///
    /// # Panics
    /// If the order of `g` or `out` is not that of the matrix.
    pub fn apply_into<T: Coefficient<Scalar = S>>(&self, g: &[T], out: &mut [T]) {
        let orders = [order_of_slice(g), order_of_slice(out)];
        assert_eq!(orders, [self.order; 2], "orders of the factor and the product against that of the matrix");
        out.fill(T::ZERO);
        // By rows of the symmetric matrix, so that the sums are independent of each other.
        for (g, row) in g.iter().zip(self.entries.chunks_exact(out.len().max(1))) {
            for (out, m) in out.iter_mut().zip(row) {
                *out += g.scale(*m);
            }
        }
    }
}

/// `weight ∫ f(z, φ) (cos mφ, sin mφ) dφ` for `m` below `count`.
fn row_series(grid: &RowGrid, z: f64, weight: f64, count: usize, f: &mut impl FnMut(Dir) -> f64) -> Vec<(f64, f64)> {
    let r = ((1.0 - z) * (1.0 + z)).sqrt();
    let mut series = vec![(0.0, 0.0); count];
    for k in 0..grid.azimuths {
        let (x, y) = grid.turn(1, k);
        let value = weight * 2.0 * PI / grid.azimuths as f64 * f(Dir::from_unit([r * x, r * y, z]));
        for (m, (cos, sin)) in series.iter_mut().enumerate() {
            let (c, s) = grid.turn(m, k);
            *cos += value * c;
            *sin += value * s;
        }
    }
    series
}

/// `∫ f trig_i trig_j dφ` with cosines for `m >= 0`, sines for `m < 0`, by the formulas for products of two.
fn azimuthal(series: &[(f64, f64)], m_i: isize, m_j: isize) -> f64 {
    let (a, b) = (m_i.unsigned_abs(), m_j.unsigned_abs());
    let (sum, difference) = (series[a + b], series[a.abs_diff(b)]);
    match (m_i < 0, m_j < 0) {
        (false, false) => 0.5 * (difference.0 + sum.0),
        (true, true) => 0.5 * (difference.0 - sum.0),
        (true, false) => 0.5 * (sum.1 + if a >= b { difference.1 } else { -difference.1 }),
        (false, true) => 0.5 * (sum.1 + if b >= a { difference.1 } else { -difference.1 }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::{ShL2, ShL4, ShVec};
    use crate::projection::project;
    use lobe_testkit::Random;

    /// Sums of some hundred terms of size one.
    const ROUNDING: f64 = 1e-13;

    fn random(order: usize, seed: u64) -> ShVec<f64> {
        ShVec::from_vec(Random::new(seed).signed_vec(coefficient_count(order))).unwrap()
    }

    #[test]
    fn the_matrix_multiplies() {
        for (order_f, order) in [(0, 3), (0, 12), (1, 1), (2, 3), (3, 5), (6, 6), (7, 4), (12, 4), (3, 12)] {
            let (f, g) = (random(order_f, 1), random(order, 2));
            let expected = f.product(&g, order);
            let mut mine = ShVec::zero(order);
            ProductMatrix::new(&f, order).apply_into(g.coefficients(), mine.coefficients_mut());
            for i in 0..coefficient_count(order) {
                let (a, b) = (mine[i], expected[i]);
                assert!((a - b).abs() < ROUNDING, "orders {order_f} and {order}, coefficient {i}: {a} against {b}");
            }
        }
    }

    #[test]
    fn the_matrix_is_symmetric_and_equals_quadrature() {
        for (order_f, order) in [(3, 4), (5, 3), (6, 6)] {
            let f = random(order_f, 3);
            let exact = ProductMatrix::new(&f, order);
            let by_quadrature = ProductMatrix::<f64>::from_fn(order, order_f - 1, |s| f.eval(s));
            for i in 0..coefficient_count(order) {
                for j in 0..coefficient_count(order) {
                    let (a, b) = (exact.entry(i, j), by_quadrature.entry(i, j));
                    assert!((a - b).abs() < ROUNDING, "({i}, {j}): {a} against {b}");
                    assert!((a - exact.entry(j, i)).abs() < ROUNDING, "({i}, {j}) and ({j}, {i})");
                }
            }
        }
    }

    #[test]
    fn the_transfer_matrix_of_a_shadow_y_22_has_54_entries() {
        let mut shadow = ShL2::<f64>::zero();
        shadow[coefficient_index(2, 2)] = 1.0;
        let exact = ProductMatrix::new(&shadow, 5);
        let count = exact.entries().iter().filter(|&&m| m != 0.0).count();
        assert_eq!((count, exact.entries().len()), (54, 625), "non-zeros of all, from the tensor");
        let sampled = ProductMatrix::<f64>::from_fn(5, 2, |s| shadow.eval(s));
        let count = sampled.entries().iter().filter(|m| m.abs() > ROUNDING).count();
        assert_eq!(count, 54, "non-zeros by quadrature");
    }

    #[test]
    fn a_transfer_matrix_shadows_light() {
        // Visible above the horizon, smoothly: V = (1 + z)/2, so degree 1 is exact.
        let visible = |s: Dir| 0.5 * (1.0 + s.z());
        let light = ShL4::<f64>::impulse(Dir::X, 3.0);
        let mut mine = ShL4::zero();
        ProductMatrix::from_fn(5, 1, visible).apply_into(light.coefficients(), mine.coefficients_mut());
        let expected = project(5, 5, |s| visible(s) * light.eval(s));
        for i in 0..25 {
            assert!((mine[i] - expected[i]).abs() < ROUNDING, "{i}: {} against {}", mine[i], expected[i]);
        }
    }
}
