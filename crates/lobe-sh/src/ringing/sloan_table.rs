//! Sloan's lower bound of a function of three bands, and his table of windows.

use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::basis::index::order_of;
use crate::extrema::quadratic_form::QuadraticForm;
use crate::scalar::Real;
use crate::sphere::vector::{dot, unit};

/// The windows between which the table interpolates: `(w, p, e)` are the factors `sinc(π l/w)^p`, that of band 1
/// times `e`. They begin from no window, and under the last even an impulse of light has no negative irradiance.
const ROWS: [(f64, f64, f64); 3] = [(12.0, 4.5, 0.99), (10.0, 5.0, 0.98), (6.5, 5.5, 0.94)];

/// Bisections of the table's range, to one part in 10⁷.
const HALVINGS: usize = 24;

/// A lower bound of the least value of a function of up to three bands.
///
/// In the frame whose +z is the linear direction `b`, with `ζ` the zonal part of band 2 about it and `q_1, q_2` the
/// amplitudes of its `|m| = 1` and `|m| = 2` parts, both at their worst phase at once,
///
/// ```text
///   g(z) = c + b z + ζ z² - (ζ/2 + q_2) (1 - z²) + 2 q_1 z √(1 - z²)        -1 <= z <= 0
/// ```
///
/// With its true phases this is `f`, so that `min g <= min f`. The other hemisphere has the worst phase `-2 q_1 z √(1 -
/// z²)`, which mirrored to `-z` is the same with a lower linear part, so that it adds nothing. `g` is a quadratic form
/// in `(z, √(1 - z²))`, so that its minimum is exact, where the source takes Newton steps. The bound is below the true
/// minimum, by 0.12 on average for coefficients of unit variance (test `the_bound_is_conservative_and_this_loose`); the
/// true one, [`certified_minimum`](crate::extrema::certified_minimum), costs no more.
///
/// Source: [Sloan 2017], section 2.3, where in print `a` has `z³/π` for `1/√π`, the signs of the cases of the quadratic
/// minimum are exchanged and `|m| < 0` stands for `|m| > 0`. For a function without a linear part the frame is Lobe's
/// own.
///
/// # Panics
/// If there are more than 9 coefficients, or not `n²`.
///
/// [Sloan 2017]: https://www.ppsloan.org/publications/shdering.pdf
#[must_use]
pub fn conservative_minimum<T: Real>(coefficients: &[T]) -> f64 {
    let count = coefficients.len();
    assert!(count <= 9 && order_of(count).is_some(), "the bound is for 0, 1, 4 or 9 coefficients, not {count}");
    let (form, scale) = QuadraticForm::normalized(coefficients, 0);
    bound(&form, [1.0, 1.0]) / scale
}

/// [`conservative_minimum`] of a function whose bands 1 and 2 are scaled by `w`.
fn bound(form: &QuadraticForm, w: [f64; 2]) -> f64 {
    let (b, a) = form.parts();
    let length = dot(b, b).sqrt();
    let z = if length > 0.0 { unit(b) } else { [0.0, 0.0, 1.0] };
    let az = a.map(|row| dot(row, z));
    let zeta = dot(z, az);
    let across = [0, 1, 2].map(|k| az[k] - zeta * z[k]);
    let q1 = dot(across, across).sqrt();
    // |A|² = ζ² + 2 q_1² + ζ²/2 + 2 q_2²: the block across z has the trace -ζ and the eigenvalues -ζ/2 ± q_2.
    let square: f64 = a.iter().map(|row| dot(*row, *row)).sum();
    let q2 = (0.5 * (square - 1.5 * zeta * zeta) - q1 * q1).max(0.0).sqrt();
    // Coordinates (z, r, third), the third like r but not coupled; the trace goes into the constant.
    let across = -(0.5 * zeta + q2) * w[1];
    let mean = (zeta * w[1] + 2.0 * across) / 3.0;
    let matrix = [zeta * w[1] - mean, across - mean, across - mean, q1 * w[1], 0.0, 0.0];
    QuadraticForm::from_parts(form.c + mean, [length * w[0], 0.0, 0.0], matrix).minimum([1.0, 1.0]).lo
}

/// The factors of bands 0 to 3 at a place of Sloan's table of windows, from 0, no window, to 1, the strongest; the
/// seven published rows are at sixths. Places outside are the nearest end.
///
/// Source: [Sloan 2017], whose entries these formulas give to 3e-7 (test `the_table_is_the_published_one`).
///
/// ```text
///   w_l = sinc(π l/w)^p, w_1 times e besides        (w, p, e) = (12, 4.5, 0.99), (10, 5, 0.98), (6.5, 5.5, 0.94)
/// ```
///
/// for the third, fifth and last row; in between the factors change in proportion.
///
/// [Sloan 2017]: https://www.ppsloan.org/publications/shdering.pdf
#[must_use]
pub fn dering_table_factors(place: f64) -> [f64; 4] {
    let place = place.clamp(0.0, 1.0) * ROWS.len() as f64;
    let row = (place as usize).min(ROWS.len() - 1);
    let part = place - row as f64;
    let before = if row == 0 { [1.0; 4] } else { row_factors(row - 1) };
    let after = row_factors(row);
    [0, 1, 2, 3].map(|l| before[l] + part * (after[l] - before[l]))
}

fn row_factors(row: usize) -> [f64; 4] {
    let (width, power, extra) = ROWS[row];
    [0, 1, 2, 3].map(|l| {
        if l == 0 {
            return 1.0;
        }
        let x = PI * l as f64 / width;
        (x.sin() / x).powf(power) * if l == 1 { extra } else { 1.0 }
    })
}

/// The first place of the table at which the bounds of all channels are at least `margin` times their means; `None` if
/// there is none.
pub(crate) fn table_place(channels: &[QuadraticForm], margin: f64) -> Option<f64> {
    let holds = |place: f64| {
        let [_, w1, w2, _] = dering_table_factors(place);
        channels.iter().all(|q| bound(q, [w1, w2]) >= margin * q.c)
    };
    if holds(0.0) {
        return Some(0.0);
    }
    if !holds(1.0) {
        return None;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle) { high = middle } else { low = middle }
    }
    Some(high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::{Expansion as _, ShL2, Zonal};
    use crate::extrema::branch_and_bound::certified_minimum;
    use crate::rotation::Rotation;
    use crate::sphere::Dir;
    use lobe_testkit::{Random, golden, golden_f64s};

    #[test]
    fn the_table_is_the_published_one() {
        let rows = golden("/dering_table").as_array().unwrap().len();
        for row in 0..rows {
            let published = golden_f64s(&format!("/dering_table/{row}"));
            let factors = dering_table_factors(row as f64 / (rows - 1) as f64);
            for (l, (found, published)) in factors[1..].iter().zip(published).enumerate() {
                assert!((found - published).abs() < 3e-7, "row {row}, band {}: {found} {published}", l + 1);
            }
        }
    }

    #[test]
    fn only_the_last_row_makes_the_irradiance_of_an_impulse_positive() {
        let f = ShL2::<f64>::impulse(Dir::Z, 1.0).convolved(&Zonal::clamped_cosine(3));
        let published = [-0.158333, -0.120294, -0.088160, -0.069988, -0.053942, -0.003544, 0.000544];
        for (row, published) in published.into_iter().enumerate() {
            let [_, w1, w2, _] = dering_table_factors(row as f64 / 6.0);
            let form = QuadraticForm::new(f.coefficients(), 0);
            let scaled = bound(&form, [w1, w2]) / form.c;
            assert!((scaled - published).abs() < 2e-6, "row {row}: {scaled} against {published}");
        }
    }

    #[test]
    fn the_bound_is_conservative_and_this_loose() {
        let mut random = Random::new(1);
        let (count, mut sum, mut least) = (2000, 0.0, f64::INFINITY);
        for case in 0..count {
            // Sums of twelve uniform numbers are nearly normal, of variance 12/3 · 1/4 = 1 when halved.
            let f: Vec<f64> = (0..9).map(|_| 0.5 * random.signed_vec(12).iter().sum::<f64>()).collect();
            let (bound, min) = (conservative_minimum(&f), certified_minimum(&f, 0.0));
            assert!(bound <= min.hi, "case {case}: {bound} above {min:?}");
            sum += min.hi - bound;
            least = least.min(min.hi - bound);
        }
        let mean = sum / f64::from(count);
        assert!((0.11..0.14).contains(&mean), "mean gap {mean}, least {least}");
    }

    /// `g` as printed, errata removed, for functions whose linear direction is +z, searched densely.
    #[test]
    fn the_bound_is_the_least_value_of_its_polynomial() {
        let mut random = Random::new(4);
        for case in 0..200 {
            let mut f = random.signed_vec(9);
            (f[1], f[3]) = (0.0, 0.0);
            f[2] = f[2].abs();
            let (root, third) = (PI.sqrt(), 3.0_f64.sqrt());
            let (fifth, fifteenth) = (5.0_f64.sqrt(), 15.0_f64.sqrt());
            let (q1, q2) = (f[5].hypot(f[7]), f[4].hypot(f[8]));
            let a = (3.0 * fifth * f[6] + fifteenth * q2) / (4.0 * root);
            let b = third * f[2] / (2.0 * root);
            let c = f[0] / (2.0 * root) - (fifth * f[6] + fifteenth * q2) / (4.0 * root);
            let e = fifteenth * q1 / (2.0 * root);
            let g = |theta: f64| {
                let (r, z) = theta.sin_cos();
                // Below the equator; above, the worst phase has the other sign.
                a * z * z + b * z + c - e * z.abs() * r
            };
            let steps = 20_000;
            let least = (0..=steps).map(|k| g(PI * f64::from(k) / f64::from(steps))).fold(f64::INFINITY, f64::min);
            let bound = conservative_minimum(&f);
            assert!((bound - least).abs() < 1e-7, "case {case}: {bound} against {least}");
        }
    }

    #[test]
    fn the_bound_does_not_depend_on_the_frame() {
        let mut random = Random::new(2);
        for _ in 0..200 {
            let f = ShL2::<f64>::from_slice(&random.signed_vec(9));
            let turned = f.rotated(&Rotation::from_quaternion(random.quaternion()).unwrap());
            let (a, b) = (conservative_minimum(f.coefficients()), conservative_minimum(turned.coefficients()));
            assert!((a - b).abs() < 1e-12, "{a} and turned {b}");
        }
    }

    #[test]
    fn the_bound_is_exact_for_zonal_functions() {
        let mut random = Random::new(3);
        for _ in 0..200 {
            let mut z = random.signed_vec(3);
            z[1] = z[1].abs() + 0.01;
            let f = Zonal::new(z).towards(Dir::from_unit(random.direction()), 1.0);
            let (bound, min) = (conservative_minimum(f.coefficients()), certified_minimum(f.coefficients(), 0.0));
            // q_1 and q_2 are roots of rounding errors here.
            assert!(bound <= min.hi && min.hi - bound < 1e-7, "{bound} against {min:?}");
        }
    }

    #[test]
    fn functions_without_a_linear_part_have_a_bound_too() {
        assert_eq!(conservative_minimum::<f64>(&[]), 0.0, "nothing");
        let mut f = [0.0; 9];
        assert_eq!(conservative_minimum(&f), 0.0, "zero");
        (f[0], f[4]) = (1.0, 0.3);
        let (bound, min) = (conservative_minimum(&f), certified_minimum(&f, 0.0));
        assert!(bound <= min.hi && min.hi - bound < 1e-12, "xy alone is at its worst phase: {bound} {min:?}");
    }
}
