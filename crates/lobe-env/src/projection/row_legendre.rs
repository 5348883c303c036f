//! Associated Legendre functions over the rows of a lat-long picture: integrated, or at the centers.

use std::f64::consts::PI;

use lobe_sh::basis::{Basis, coefficient_count, coefficient_index};
use lobe_sh::sphere::gauss_legendre;

use crate::mapping::lat_long::sin_cos_pi;

/// The largest error of a row integral, for a wave of amplitude 1 over an interval of length 2: below the rounding
/// error of the sum itself.
const QUADRATURE_REST: f64 = 1e-17;

// The basis function of band l and m >= 0 is P̃_l^m(cos θ) cos mφ (sin mφ for -m), with P̃ the associated Legendre
// function, all normalization and the Condon-Shortley phase folded in. Its integral over a texel is
//
//     ∫∫ y_lm ds = ∫_row P̃_l^m(cos θ) sin θ dθ · ∫_column cos mφ dφ
//
// The first integrand is a trigonometric polynomial of degree l + 1 in θ. On a row, θ = θ_c + t π/(2h) with t in
// [-1, 1], so it is a sum of waves e^{iαt} with |α| <= (l + 1) π/(2h). K Gauss-Legendre nodes integrate such a wave
// with the error
//
//     |rest| <= 2^{2K+1} K!⁴ / ((2K+1) (2K)!³) α^{2K}
//
// (the remainder of Gauss quadrature, with 2K-th derivative at most α^{2K}). K = 1 leaves α²/3; from K to K + 1 the
// bound is multiplied by 4 (K+1)⁴ (2K+1) / ((2K+3) ((2K+1)(2K+2))³) α². The smallest K whose bound is below
// QUADRATURE_REST is taken: 5 nodes for order 6 and 128 rows, 7 for order 64 and 256 rows, 85 for order 64 and a
// single row. So the integrals are exact to rounding (tests `row_integrals_equal_their_closed_forms` and
// `row_integrals_of_all_bands_do_not_change_with_more_nodes`).

/// `P̃_l^m` over the upper half of the rows of a picture; the lower half follows from
/// `P̃_l^m(-z) = (-1)^{l+m} P̃_l^m(z)`.
pub(crate) struct RowLegendre {
    order: usize,
    height: usize,
    rule: Vec<(f64, f64)>,
}

impl RowLegendre {
    /// For integrals over the rows.
    pub(crate) fn integrals(order: usize, height: usize) -> Self {
        Self { order, height, rule: gauss_legendre(nodes(order, height)) }
    }

    /// For values at the centers of the rows.
    pub(crate) fn values(order: usize, height: usize) -> Self {
        Self { order, height, rule: vec![(0.0, 1.0)] }
    }

    /// `∫_row P̃_l^m(cos θ) sin θ dθ` of row `y`, into `out[coefficient_index(l, m)]` for `m >= 0`.
    pub(crate) fn integrate_into(&self, y: usize, out: &mut [f64]) {
        out.fill(0.0);
        let half = PI / (2.0 * self.height as f64);
        let mut values = vec![0.0; coefficient_count(self.order)];
        for &(t, weight) in &self.rule {
            let sin_theta = self.eval_at(y, t, &mut values);
            for (sum, value) in out.iter_mut().zip(&values) {
                *sum += weight * half * sin_theta * value;
            }
        }
    }

    /// `P̃_l^m(cos θ)` at the center of row `y`, into `out[coefficient_index(l, m)]` for `m >= 0`.
    pub(crate) fn eval_into(&self, y: usize, out: &mut [f64]) {
        self.eval_at(y, 0.0, out);
    }

    /// The values at `t` in `[-1, 1]` across row `y`; returns `sin θ` there.
    fn eval_at(&self, y: usize, t: f64, out: &mut [f64]) -> f64 {
        let (sin_theta, cos_theta) = sin_cos_pi((y as f64 + 0.5 + 0.5 * t) / self.height as f64);
        // Towards φ = 0 the basis function of m >= 0 is P̃ itself.
        Basis::<f64>::with_shared(self.order, |basis| basis.eval_into([sin_theta, 0.0, cos_theta], out));
        sin_theta
    }
}

/// The number of Gauss nodes for rows of a picture of `height` rows; see the derivation above.
fn nodes(order: usize, height: usize) -> usize {
    let alpha = order as f64 * PI / (2.0 * height as f64);
    let mut rest = alpha * alpha / 3.0;
    let mut count = 1;
    while rest > QUADRATURE_REST {
        let k = count as f64;
        let pair = (2.0 * k + 1.0) * (2.0 * k + 2.0);
        rest *= 4.0 * (k + 1.0).powi(4) * (2.0 * k + 1.0) / ((2.0 * k + 3.0) * pair.powi(3)) * alpha * alpha;
        count += 1;
    }
    count
}

/// Calls `f(m, l, index of (l, m))` for all `0 <= m <= l < order`, column by column of equal `m`.
#[inline(always)]
pub(crate) fn for_each_column(order: usize, mut f: impl FnMut(usize, usize, usize)) {
    for m in 0..order {
        for l in m..order {
            f(m, l, coefficient_index(l, m as isize));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn row_integrals_equal_their_closed_forms() {
        // ∫ sin θ = -cos θ;  ∫ cos θ sin θ = sin²θ/2;  ∫ sin²θ = (θ - sin θ cos θ)/2
        for height in [1, 2, 3, 16, 255] {
            let polar = RowLegendre::integrals(64, height);
            let mut out = vec![0.0; coefficient_count(64)];
            for y in 0..height {
                polar.integrate_into(y, &mut out);
                let (a, b) = (PI * y as f64 / height as f64, PI * (y + 1) as f64 / height as f64);
                let norm = (4.0 * PI).sqrt().recip();
                let expected = [
                    (0, norm * (a.cos() - b.cos())),
                    (2, norm * 3.0_f64.sqrt() * 0.5 * (b.sin().powi(2) - a.sin().powi(2))),
                    (3, -norm * 3.0_f64.sqrt() * 0.5 * (b - a - b.sin() * b.cos() + a.sin() * a.cos())),
                ];
                for (i, expected) in expected {
                    assert!((out[i] - expected).abs() < 1e-15, "{height} rows, row {y}, i {i}: {} {expected}", out[i]);
                }
            }
        }
    }

    #[test]
    fn row_integrals_of_all_bands_do_not_change_with_more_nodes() {
        for (order, height) in [(6, 128), (64, 1), (64, 7), (64, 256), (100, 3)] {
            let polar = RowLegendre::integrals(order, height);
            let finer =
                RowLegendre { rule: gauss_legendre(2 * polar.rule.len() + 3), ..RowLegendre::integrals(order, height) };
            let (mut a, mut b) = (vec![0.0; coefficient_count(order)], vec![0.0; coefficient_count(order)]);
            for y in 0..height.div_ceil(2) {
                polar.integrate_into(y, &mut a);
                finer.integrate_into(y, &mut b);
                for i in 0..a.len() {
                    let error = (a[i] - b[i]).abs();
                    assert!(error < 1e-14, "order {order}, {height} rows, row {y}, i {i}: {} and {}", a[i], b[i]);
                }
            }
        }
    }

    #[test]
    fn the_number_of_nodes_is_as_documented() {
        let found = [(6, 128), (64, 256), (64, 1)].map(|(order, height)| nodes(order, height));
        assert_eq!(found, [5, 7, 85], "nodes");
    }
}
