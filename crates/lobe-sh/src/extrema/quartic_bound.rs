//! A lower bound of a quartic polynomial on a disc, tight in curved valleys.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::extrema::taylor::Taylor;

/// Newton steps towards the floor of the valley; any number of them gives a bound.
const STEPS: usize = 3;

/// The rounding errors of this bound, relative to the largest term.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A lower bound of the polynomial for `|u|, |v| <= radius`; -∞ where it does not curve upwards along `u`.
///
/// In a curved valley, such as part of a ring, a bound of second order has an error of the third power of the radius.
/// Here the polynomial is taken as one in `u` whose coefficients depend on `v`, and minimized over `u`:
///
/// ```text
///   P(u, v) = a(v) + b(v) u + k(u, v) u²  >=  a(v) - b(v)²/4κ        k >= κ > 0 on the disc
/// ```
///
/// after `u` was shifted to the floor of the valley at `v = 0`, so that `b(0) = 0` but for rounding. The loss by `κ` is
/// of the fifth power. The right-hand side is a polynomial of sixth degree in one variable, and is bounded in the same
/// way.
pub(crate) fn quartic_lower_bound(taylor: &Taylor, radius: f64) -> f64 {
    let mut c = taylor.c;
    let size: f64 =
        c.iter().rev().fold(0.0, |sum, row| sum * radius + row.iter().rev().fold(0.0, |sum, c| sum * radius + c.abs()));
    let floor = low_point(&c.map(|row| row[0]), radius);
    for j in 0..5 {
        let mut column = c.map(|row| row[j]);
        shift(&mut column, floor);
        for (row, c) in c.iter_mut().zip(column) {
            row[j] = c;
        }
    }
    let reach = radius + floor.abs();
    let kappa = c[2][0]
        - radius * (c[2][1].abs() + radius * c[2][2].abs())
        - reach * (c[3][0].abs() + radius * c[3][1].abs() + reach * c[4][0].abs());
    if kappa <= ROUNDING * c[2][0] {
        return f64::NEG_INFINITY;
    }
    let [a, b] = [c[0], c[1]];
    let mut q = [a[0], a[1], a[2], a[3], a[4], 0.0, 0.0];
    let mut lifted = 0.0;
    for i in 0..4 {
        for j in 0..4 {
            let product = b[i] * b[j] / (4.0 * kappa);
            q[i + j] -= product;
            lifted += product.abs() * radius.powi((i + j) as i32);
        }
    }
    least_on_interval(q, radius) - ROUNDING * (size + lifted)
}

/// A lower bound of `Σ c_k xᵏ` for `|x| <= radius`.
fn least_on_interval(mut c: [f64; 7], radius: f64) -> f64 {
    let foot = low_point(&c, radius);
    shift(&mut c, foot);
    let reach = radius + foot.abs();
    let higher = c[3..].iter().rev().fold(0.0, |sum, c| (sum + c.abs()) * reach);
    let kappa = c[2] - higher;
    // Over all x, if the parabola is open upwards; over the interval in any case.
    let anywhere = if kappa > 0.0 { -c[1] * c[1] / (4.0 * kappa) } else { f64::NEG_INFINITY };
    c[0] + anywhere.max(-c[1].abs() * reach + kappa.min(0.0) * reach * reach)
}

/// Newton's method from 0 for a minimum of `Σ c_k xᵏ`, within the radius, while the curvature is positive.
fn low_point(c: &[f64], radius: f64) -> f64 {
    let mut x = 0.0_f64;
    for _ in 0..STEPS {
        let (mut slope, mut curvature) = (0.0, 0.0);
        for (k, c) in c.iter().enumerate().skip(1).rev() {
            let k = k as f64;
            slope = slope * x + k * c;
            if k > 1.0 {
                curvature = curvature * x + k * (k - 1.0) * c;
            }
        }
        if curvature <= 0.0 {
            break;
        }
        x = (x - slope / curvature).clamp(-radius, radius);
    }
    if x.is_finite() { x } else { 0.0 }
}

/// The coefficients of `Σ c_k (x + by)ᵏ`, by Horner's scheme.
fn shift(c: &mut [f64], by: f64) {
    for first in 0..c.len() {
        for k in (first..c.len() - 1).rev() {
            c[k] += by * c[k + 1];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    fn eval(c: &[[f64; 5]; 5], u: f64, v: f64) -> f64 {
        c.iter().rev().fold(0.0, |sum, row| sum * u + row.iter().rev().fold(0.0, |sum, c| sum * v + c))
    }

    fn least_sampled(c: &[[f64; 5]; 5], radius: f64) -> f64 {
        let steps = 60;
        let at = |k: i32| radius * f64::from(k) / f64::from(steps);
        let grid = (-steps..=steps).flat_map(|i| (-steps..=steps).map(move |j| (at(i), at(j))));
        grid.filter(|(u, v)| u * u + v * v <= radius * radius).map(|(u, v)| eval(c, u, v)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn no_sampled_value_is_below_the_bound() {
        let mut random = Random::new(1);
        let (mut bounded, cases) = (0, 2000);
        for case in 0..cases {
            let mut c = [[0.0; 5]; 5];
            for (i, row) in c.iter_mut().enumerate() {
                for c in row.iter_mut().take(5 - i) {
                    *c = random.signed() * [1.0, 0.3, 3.0][case % 3];
                }
            }
            c[1][1] = 0.0;
            c[2][0] = 2.0 * random.unit();
            for radius in [1.0, 0.3, 0.1] {
                let (bound, least) = (quartic_lower_bound(&Taylor { c }, radius), least_sampled(&c, radius));
                assert!(bound <= least, "case {case}, radius {radius}: {bound} above {least}");
                bounded += usize::from(bound.is_finite());
            }
        }
        assert!(bounded > cases, "only {bounded} of {} were bounded", 3 * cases);
    }

    /// `k (u - κ v²/2 - d)²`: zero all along a parabola, as part of a ring is, the center beside it.
    #[test]
    fn bent_valleys_are_bounded_to_the_fifth_power() {
        for (bend, aside) in [(0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (-2.0, 0.7)] {
            let mut before = f64::NAN;
            for radius in [0.1, 0.05, 0.025] {
                let d = aside * radius;
                let mut c = [[0.0; 5]; 5];
                (c[2][0], c[1][2], c[1][0]) = (3.0, -3.0 * bend, -6.0 * d);
                (c[0][4], c[0][2], c[0][0]) = (0.75 * bend * bend, 3.0 * bend * d, 3.0 * d * d);
                // A third derivative across makes the floor bend and tilt.
                c[3][0] = 0.2;
                let least = least_sampled(&c, radius).min(0.0);
                let lost = least - quartic_lower_bound(&Taylor { c }, radius);
                // Sampling misses the floor by 1e-4 of the curvature times the squared radius at the most.
                assert!(lost < 1.5 * radius.powi(4), "bend {bend}, {aside}, radius {radius}: {lost} lost");
                assert!(
                    before.is_nan() || lost < before / 12.0 + 1e-6 * radius,
                    "{bend}, {aside}: {lost} after {before}"
                );
                before = lost;
            }
        }
    }

    #[test]
    fn minima_inside_are_exact() {
        let mut c = [[0.0; 5]; 5];
        (c[0][0], c[1][0], c[2][0], c[0][1], c[0][2]) = (1.0, 0.2, 2.0, -0.1, 1.0);
        let exact = 1.0 - 0.04 / 8.0 - 0.01 / 4.0;
        let found = quartic_lower_bound(&Taylor { c }, 0.2);
        assert!((found - exact).abs() < 1e-13, "{found} against {exact}");
    }
}
