//! Projection of a function by quadrature.

use core::f64::consts::PI;

use crate::basis::index::{coefficient_count, coefficient_index};
use crate::expansion::{FixedOrder, ShVec};
use crate::prelude::*;
use crate::scalar::Coefficient;
use crate::sphere::Dir;
use crate::sphere::quadrature::SphereQuadrature;

/// The degree from which [`project_to_accuracy`] starts, beyond twice the order.
const FIRST_EXTRA_DEGREE: usize = 16;

/// The highest quadrature degree of [`project_to_accuracy`]: 2.1 million evaluations.
const LAST_DEGREE: usize = 2047;

/// The expansion of a band-limited function, exact up to rounding.
///
/// ```text
///   f_i = ∫ f(s) y_i(s) ds        i < order²
/// ```
///
/// `f` must be a spherical polynomial of at most `degree` (an expansion of order `n` has degree `n - 1`); the
/// quadrature is then exact, to 1e-13 of the largest value at order 64 (test `projection_finds_a_planted_expansion`).
/// For other functions use [`project_to_accuracy`].
///
/// ```
/// let f = lobe_sh::project(2, 1, |s| 1.0 + 0.5 * s.z());
/// assert!((f[0] - 3.544907701811032).abs() < 1e-14); // √(4π)
/// assert!((f[2] - 0.5 * 2.046653415892977).abs() < 1e-14); // 0.5 √(4π/3)
/// ```
#[must_use]
pub fn project<T: Coefficient>(order: usize, degree: usize, f: impl FnMut(Dir) -> T) -> ShVec<T> {
    quadrature_sum(order, &SphereQuadrature::of_degree(degree + order.saturating_sub(1)), f).map(T::narrow)
}

/// [`project`] to the order of the type that is asked for.
///
/// ```
/// use lobe_sh::{ShL1, project_as};
///
/// let f = project_as::<ShL1<f64>>(1, |s| 1.0 + 0.5 * s.z());
/// assert!((f[2] - 0.5 * 2.046653415892977).abs() < 1e-14); // 0.5 √(4π/3)
/// ```
#[must_use]
pub fn project_as<E: FixedOrder>(degree: usize, f: impl FnMut(Dir) -> E::Value) -> E {
    project(E::ORDER, degree, f).to_fixed()
}

/// The result of [`project_to_accuracy`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Projection<T> {
    /// The expansion.
    pub sh: ShVec<T>,
    /// The largest change of any coefficient, any channel, when the quadrature degree was last doubled: an estimate
    /// of the error, usually far above it. NaN if the function was NaN where it was evaluated.
    pub error: f64,
    /// True if `error` is within the tolerance.
    pub converged: bool,
    /// The number of evaluations of the function.
    pub evaluations: usize,
}

/// The expansion of any integrable function, to an absolute accuracy of its coefficients.
///
/// The degree of an exact rule is doubled until no coefficient changes by more than `tolerance`, or the degree
/// reaches 2047; [`Projection::converged`] says which. Smooth functions converge faster than any power of the
/// degree, kinks with its square, jumps with its first power: for a zonal function with known jumps
/// [`Zonal::project`](crate::Zonal::project) is exact instead.
///
/// The error is an estimate: features smaller than the distance of the nodes, about `180° / (2 order + 17)` at the
/// first comparison, may be missed altogether while the result counts as converged (test
/// `what_falls_between_the_nodes_is_missed`). Use [`Zonal::project`](crate::Zonal::project) for a sun.
#[must_use]
pub fn project_to_accuracy<T: Coefficient>(order: usize, tolerance: f64, mut f: impl FnMut(Dir) -> T) -> Projection<T> {
    let mut degree = 2 * order + FIRST_EXTRA_DEGREE;
    let mut rule = SphereQuadrature::of_degree(degree);
    let mut sh = quadrature_sum(order, &rule, &mut f);
    let mut evaluations = rule.len();
    let mut error = f64::INFINITY;
    while error > tolerance && degree < LAST_DEGREE {
        degree = (2 * degree + 1).min(LAST_DEGREE);
        rule = SphereQuadrature::of_degree(degree);
        let finer = quadrature_sum(order, &rule, &mut f);
        evaluations += rule.len();
        error = largest_difference(&sh, &finer);
        sh = finer;
    }
    Projection { sh: sh.map(T::narrow), error, converged: error <= tolerance, evaluations }
}

fn largest_difference<W: Coefficient<Scalar = f64>>(a: &ShVec<W>, b: &ShVec<W>) -> f64 {
    use crate::expansion::Expansion as _;
    let difference = a - b;
    let channels = difference.coefficients().iter().flat_map(|d| (0..W::CHANNELS).map(|c| d.channel(c).abs()));
    channels.fold(0.0, |largest, d| if d > largest || d.is_nan() { d } else { largest })
}

/// `Σ_jk w_jk f(s_jk) y_i(s_jk)`, one row of the rule at a time.
///
/// Along a row only `cos mφ` and `sin mφ` change, so each value is multiplied `2 order - 1` times instead of
/// `order²` times; the Legendre functions enter once for the row.
fn quadrature_sum<T: Coefficient>(
    order: usize,
    rule: &SphereQuadrature,
    mut f: impl FnMut(Dir) -> T,
) -> ShVec<T::Wide> {
    let azimuths = rule.azimuths();
    let step = 2.0 * PI / azimuths as f64;
    let turns: Vec<(f64, f64)> = (0..azimuths).map(|k| (step * k as f64).sin_cos()).collect();
    let mut sums = ShVec::<T::Wide>::zero(order);
    let mut basis = vec![0.0; coefficient_count(order)];
    for &(z, weight) in rule.rows() {
        let r = ((1.0 - z) * (1.0 + z)).sqrt();
        let mut cos_sums = vec![T::Wide::ZERO; order];
        let mut sin_sums = vec![T::Wide::ZERO; order];
        for (k, &(sin, cos)) in turns.iter().enumerate() {
            let value = f(Dir::from_unit([r * cos, r * sin, z])).widen();
            for m in 0..order {
                let (sin_m, cos_m) = turns[(m * k) % azimuths];
                cos_sums[m] += value.scale(cos_m);
                sin_sums[m] += value.scale(sin_m);
            }
        }
        // Towards φ = 0 the basis function (l, m >= 0) is the row's Legendre factor of (l, m) and (l, -m).
        crate::basis::eval_basis_into([r, 0.0, z], &mut basis);
        for l in 0..order {
            for m in 0..=l {
                let legendre = basis[coefficient_index(l, m as isize)] * weight * step;
                sums[coefficient_index(l, m as isize)] += cos_sums[m].scale(legendre);
                if m > 0 {
                    sums[coefficient_index(l, -(m as isize))] += sin_sums[m].scale(legendre);
                }
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::{Expansion as _, Zonal};
    use crate::scalar::Rgb;

    #[test]
    fn projection_finds_a_planted_expansion() {
        for order in [1, 2, 3, 7, 16, 64] {
            let planted = ShVec::from_vec(lobe_testkit::Random::new(order as u64).signed_vec(order * order)).unwrap();
            let found = project(order, order - 1, |s| planted.eval(s));
            for (i, (a, b)) in found.coefficients().iter().zip(planted.coefficients()).enumerate() {
                assert!((a - b).abs() < 1e-12, "order {order}, i {i}: {a} against {b}");
            }
        }
    }

    #[test]
    fn a_function_of_higher_degree_loses_only_its_higher_bands() {
        let planted = ShVec::from_vec(lobe_testkit::Random::new(5).signed_vec(64)).unwrap();
        let found = project(3, 7, |s| planted.eval(s));
        let difference = &found - &planted.resized(3);
        assert!(difference.dot(&difference) < 1e-26, "{difference:?}");
    }

    #[test]
    fn colors_project_channel_by_channel() {
        let found = project(2, 1, |s| Rgb::new(1.0 + s.x(), 1.0 + s.y(), 1.0 + s.z()));
        let c = (4.0 * PI / 3.0).sqrt();
        assert!((found[3].r + c).abs() < 1e-14 && found[3].g.abs() < 1e-14, "x: {:?}", found[3]);
        assert!((found[1].g + c).abs() < 1e-14 && found[1].b.abs() < 1e-14, "y: {:?}", found[1]);
        assert!((found[2].b - c).abs() < 1e-14 && found[2].r.abs() < 1e-14, "z: {:?}", found[2]);
    }

    #[test]
    fn smooth_functions_converge_to_the_tolerance() {
        // e^z: ∫ e^z y_00 ds = √(4π) sinh 1.
        let found = project_to_accuracy(4, 1e-12, |s: Dir| s.z().exp());
        assert!(found.converged, "error {}", found.error);
        let exact = (4.0 * PI).sqrt() * 1.0_f64.sinh();
        assert!((found.sh[0] - exact).abs() < 1e-13, "{} against {exact}", found.sh[0]);
    }

    #[test]
    fn jumps_are_reported_as_not_converged() {
        let cap = |s: Dir| f64::from(u8::from(s.dot(Dir::from_angles(1.0, 0.5)) > 0.9));
        let found = project_to_accuracy(3, 1e-12, cap);
        assert!(!found.converged && found.error > 1e-12, "error {}", found.error);
        let exact = Zonal::project(3, &[0.9], 8, |t| f64::from(u8::from(t > 0.9)));
        let exact = exact.towards(Dir::from_angles(1.0, 0.5), 1.0);
        assert!((found.sh[0] - exact[0]).abs() < 10.0 * found.error, "{} against {}", found.sh[0], exact[0]);
    }

    #[test]
    fn what_falls_between_the_nodes_is_missed() {
        let axis = Dir::from_angles(0.7, 1.1);
        let disc = |degrees: f64| {
            let cosine = degrees.to_radians().cos();
            project_to_accuracy(3, 1e-3, move |s: Dir| f64::from(u8::from(s.dot(axis) > cosine)))
        };
        let sun = disc(0.25);
        assert!(sun.converged && sun.sh[0] == 0.0, "a sun of half a degree became {}", sun.sh[0]);
        let wide = disc(20.0);
        let exact = PI.sqrt() * (1.0 - 20.0_f64.to_radians().cos());
        assert!((wide.sh[0] - exact).abs() < 3e-3, "a disc of 40 degrees: {} against {exact}", wide.sh[0]);
    }

    #[test]
    fn a_function_that_is_not_a_number_does_not_converge() {
        let found = project_to_accuracy(2, 1e-3, |s: Dir| if s.z() > 0.99 { f64::NAN } else { 1.0 });
        assert!(!found.converged, "error {}", found.error);
    }

    #[test]
    fn greens_example_light_has_its_sixteen_coefficients() {
        let golden = lobe_testkit::golden_f64s("/green_light16");
        let first = Zonal::project(4, &[0.8], 8, |t| (5.0 * t - 4.0).max(0.0)).towards(Dir::Z, 1.0);
        let axis = Dir::from_angles(PI / 2.0, 2.5);
        let second = Zonal::project(4, &[0.75], 8, |t| (4.0 * t - 3.0).max(0.0)).towards(axis, 1.0);
        let by_zonals = &first + &second;
        let by_quadrature = project_to_accuracy(4, 5e-6, greens_light);
        assert!(by_quadrature.converged, "error {}", by_quadrature.error);
        for i in 0..16 {
            assert!((by_zonals[i] - golden[i]).abs() < 1e-12, "i {i}: {} against {}", by_zonals[i], golden[i]);
            let c = by_quadrature.sh[i];
            let error = by_quadrature.error;
            assert!((c - golden[i]).abs() < error, "i {i}: {c} against {}, reported error {error}", golden[i]);
        }
    }

    /// The light of Green 2003 as printed, in angles.
    fn greens_light(s: Dir) -> f64 {
        let (theta, phi) = (s.theta(), s.phi());
        (5.0 * theta.cos() - 4.0).max(0.0) + (-4.0 * (theta - PI).sin() * (phi - 2.5).cos() - 3.0).max(0.0)
    }
}
