//! Least squares over the hemisphere of normals on one side of a surface.

use crate::expansion::{Expansion, ShVec};
use crate::prelude::*;
use crate::projection::least_squares::least_squares;
use crate::rotation::rotation::tangent_frame;
use crate::scalar::Coefficient;
use crate::sphere::Dir;
use crate::sphere::quadrature::gauss_legendre;

/// Points on the hemisphere `z > 0` and weights that integrate polynomials up to `degree` over it exactly.
///
/// ```text
///   ∫_{z>0} f ds = Σ_j Σ_k (w_j/2) (2π/K) f((1 + x_j)/2, φ_k)        K = degree + 1
/// ```
pub(crate) fn hemisphere_points(degree: usize) -> Vec<(Dir, f64)> {
    let azimuths = degree + 1;
    let step = core::f64::consts::TAU / azimuths as f64;
    let mut points = Vec::new();
    for (x, weight) in gauss_legendre(degree / 2 + 1) {
        let z = 0.5 * (1.0 + x);
        let r = ((1.0 - z) * (1.0 + z)).sqrt();
        for k in 0..azimuths {
            let (sin, cos) = (step * k as f64).sin_cos();
            points.push((Dir::from_unit([r * cos, r * sin, z]), 0.5 * weight * step));
        }
    }
    points
}

/// The expansion of `order` that is nearest to `f` over the hemisphere around `normal`, and arbitrary elsewhere.
///
/// ```text
///   minimize ∫_{s·normal > 0} (g(s) - f(s))² ds        g of order n
/// ```
///
/// No normal of a surface points behind it, so that values there are free to lower the error: for the irradiance of one
/// light by 7 % against truncation at order 3, by 25 % at order 2 (test
/// `fitting_the_hemisphere_alone_has_the_known_errors`). The matrix of this problem has condition numbers 14, 254 and
/// 5875 at orders 2, 3 and 4 (test `the_hemispherical_matrix_has_its_known_entries_and_condition`); those of the
/// factored matrix are their square roots. After Sloan, Hall, Hart and Snyder 2003.
///
/// # Panics
/// If `order` is 0.
#[must_use]
pub fn hemisphere_least_squares<T: Coefficient>(order: usize, normal: Dir, f: &impl Expansion<T>) -> ShVec<T> {
    let frame = tangent_frame(normal);
    let degree = 2 * order.max(f.order()).saturating_sub(1);
    let points = hemisphere_points(degree).into_iter().map(|(s, weight)| (frame.rotate_dir(s), weight));
    least_squares(order, points.map(|(s, weight)| (s, f.eval(s), weight))).sh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::eval_basis;
    use crate::expansion::Zonal;
    use crate::sphere::quadrature::SphereQuadrature;
    use lobe_testkit::{Random, directions};
    use nalgebra::DMatrix;

    #[test]
    fn frames_take_plus_z_to_the_normal() {
        for v in directions() {
            let normal = Dir::from_unit(v);
            let off = tangent_frame(normal).rotate_dir(Dir::Z).angle_to(normal);
            assert!(off < 1e-14, "{v:?} is missed by {off}");
        }
    }

    #[test]
    fn the_hemispherical_matrix_has_its_known_entries_and_condition() {
        for (order, condition) in [(2, 13.93), (3, 254.0), (4, 5875.0), (5, 1.517e5), (6, 4.159e6), (7, 1.185e8)] {
            let n = order * order;
            let mut gram = DMatrix::<f64>::zeros(n, n);
            for (s, weight) in hemisphere_points(2 * (order - 1)) {
                let y = DMatrix::from_vec(n, 1, eval_basis(s, order));
                gram += &y * y.transpose() * weight;
            }
            let values = gram.clone().symmetric_eigenvalues();
            let found = values.max() / values.min();
            assert!((found / condition - 1.0).abs() < 1e-3, "order {order}: condition {found} against {condition}");
            for i in 0..n {
                assert!((gram[(i, i)] - 0.5).abs() < 1e-14, "order {order}, {i}: {}", gram[(i, i)]);
            }
            if order == 3 {
                let entry = |i: usize, j: usize, x: f64| {
                    assert!((gram[(i, j)] - x).abs() < 1e-14, "entry {i}, {j}: {} against {x}", gram[(i, j)]);
                };
                entry(0, 2, 3.0_f64.sqrt() / 4.0);
                entry(1, 5, 3.0 * 5.0_f64.sqrt() / 16.0);
                entry(2, 6, 15.0_f64.sqrt() / 16.0);
            }
        }
    }

    #[test]
    fn what_fits_is_found_whatever_the_normal() {
        let f = ShVec::from_vec(Random::new(1).signed_vec(9)).unwrap();
        for v in directions() {
            let g = hemisphere_least_squares(3, Dir::from_unit(v), &f.resized(5));
            for (i, (a, b)) in g.coefficients().iter().zip(f.coefficients()).enumerate() {
                assert!((a - b).abs() < 1e-11, "normal {v:?}, i {i}: {a} against {b}");
            }
        }
    }

    /// The RMS error over the hemisphere and over all lights of irradiance 1 on a surface that faces them.
    #[test]
    fn fitting_the_hemisphere_alone_has_the_known_errors() {
        const ORDER: usize = 24;
        let points = hemisphere_points(60);
        for (order, cut_off, fitted) in [(2, 0.1443, 0.1079), (3, 0.0361, 0.0336)] {
            let (mut squares, mut cut_squares, mut total) = (0.0, 0.0, 0.0);
            for (sun, weight) in SphereQuadrature::of_degree(12).points() {
                let e = Zonal::clamped_cosine(ORDER).towards(sun, 1.0);
                let (g, cut) = (hemisphere_least_squares(order, Dir::Z, &e), e.resized(order));
                for (n, w) in &points {
                    let truth = n.dot(sun).max(0.0);
                    squares += weight * w * (g.eval(*n) - truth).powi(2);
                    cut_squares += weight * w * (cut.eval(*n) - truth).powi(2);
                    total += weight * w;
                }
            }
            let (found, cut) = ((squares / total).sqrt(), (cut_squares / total).sqrt());
            assert!((found - fitted).abs() < 2e-4, "order {order}: {found} against {fitted}");
            assert!((cut - cut_off).abs() < 2e-4, "order {order}, cut off: {cut} against {cut_off}");
        }
    }
}
