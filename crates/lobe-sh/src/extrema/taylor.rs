//! The Taylor polynomial of fourth degree of a function on the sphere, and bounds of its derivatives.

use crate::basis::index::MAX_ORDER;
use crate::basis::index::{band_range, order_of_slice};
use crate::once::Once;
use crate::prelude::*;
use crate::rotation::cos_sin::CosSin;
use crate::rotation::zyz::rotate_bands_zyz;

/// Derivatives of order 0 to 5 are kept: four for the polynomial, the fifth for its remainder.
pub(crate) const DERIVATIVES: usize = 6;

/// The derivatives of the basis along the meridians at the pole, for every band.
///
/// ```text
///   y_l,±m(θ, φ) = N_lm(θ) {cos mφ, sin mφ}          t_k,m = dᵏN_lm/dθᵏ (0)
///
///   N_l0(0) = √((2l+1)/4π), others 0        dN_m/dθ = (a_m N_{m+1} - a_{m-1} N_{m-1}) / 2        a_m = √((l-m)(l+m+1))
/// ```
///
/// for the complex basis, where `N_-1 = -N_1`; real functions of `m > 0` are `√2` times as large.
pub(crate) struct PoleDerivatives {
    /// For each band, `t_k,m` of the real functions, `m` up to `k`.
    bands: Vec<[[f64; DERIVATIVES]; DERIVATIVES]>,
}

impl PoleDerivatives {
    /// Calls `f` with a table of at least `order` bands.
    pub(crate) fn with_shared<R>(order: usize, f: impl FnOnce(&Self) -> R) -> R {
        static SHARED: Once<PoleDerivatives> = Once::new();
        if order <= MAX_ORDER { f(SHARED.get_or_init(|| Self::new(MAX_ORDER))) } else { f(&Self::new(order)) }
    }

    fn new(order: usize) -> Self {
        Self { bands: (0..order).map(Self::of_band).collect() }
    }

    fn of_band(l: usize) -> [[f64; DERIVATIVES]; DERIVATIVES] {
        let ladder = |m: usize| if m < l { (((l - m) * (l + m + 1)) as f64).sqrt() } else { 0.0 };
        let mut t = [[0.0; DERIVATIVES]; DERIVATIVES];
        t[0][0] = ((2 * l + 1) as f64 / (4.0 * core::f64::consts::PI)).sqrt();
        for k in 1..DERIVATIVES {
            let before = t[k - 1];
            // N_m has no derivative below the m-th.
            t[k][0] = ladder(0) * before[1];
            for m in 1..=k {
                let above = before.get(m + 1).map_or(0.0, |n| ladder(m) * n);
                t[k][m] = 0.5 * (above - ladder(m - 1) * before[m - 1]);
            }
        }
        for row in &mut t {
            row[1..].iter_mut().for_each(|t| *t *= core::f64::consts::SQRT_2);
        }
        t
    }

    /// Upper bounds of the derivatives of order 0 to 5 of the function along any great circle, see
    /// [`SmoothFunction`](crate::extrema::cap_bound::SmoothFunction).
    pub(crate) fn bounds(&self, coefficients: &[f64]) -> [f64; DERIVATIVES] {
        let mut bounds = [0.0; DERIVATIVES];
        for l in 0..order_of_slice(coefficients) {
            let energy: f64 = coefficients[band_range(l)].iter().map(|c| c * c).sum();
            for (bound, row) in bounds.iter_mut().zip(&self.bands[l]) {
                *bound += (row.iter().map(|t| t * t).sum::<f64>() * energy).sqrt();
            }
        }
        bounds
    }
}

/// The terms to fourth order of `f(exp_s(u a + v b)) = Σ c_ij uⁱ vʲ`, where `exp` follows great circles and the
/// tangents `a, b` are the principal axes of the curvature, the larger along `a`: `c_11 = 0`, `c_20 >= c_02`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Taylor {
    /// `c[i][j]`, 0 for `i + j > 4`.
    pub(crate) c: [[f64; 5]; 5],
}

impl Taylor {
    /// The function is rotated until `s` is the pole. There, with `C_km = Σ_l t_k,m f_lm / k!` and `S_km` the same of
    /// `f_l,-m`,
    ///
    /// ```text
    ///   f(θ, φ) = Σ_k θᵏ Σ_m C_km cos mφ + S_km sin mφ        m = k, k-2, ..
    /// ```
    ///
    /// and `θᵏ cos mφ`, `θᵏ sin mφ` are the parts of `(u² + v²)^((k-m)/2) (u + iv)^m`. `work` holds as many numbers as
    /// `coefficients`.
    pub(crate) fn new(table: &PoleDerivatives, coefficients: &[f64], s: [f64; 3], work: &mut [f64]) -> Self {
        work.copy_from_slice(coefficients);
        let azimuth = CosSin::of_vector(s[0], s[1]);
        let angles = [
            CosSin { cos: 1.0, sin: 0.0 },
            CosSin { cos: s[2], sin: -s[0].hypot(s[1]) },
            CosSin { sin: -azimuth.sin, ..azimuth },
        ];
        rotate_bands_zyz(angles, work);
        let mut waves = [[[0.0; 2]; 5]; 5];
        for l in 0..order_of_slice(work) {
            let (band, t) = (&work[band_range(l)], &table.bands[l]);
            for m in 0..=l.min(4) {
                let [plus, minus] = [band[l + m], band[l - m]];
                for k in (m..5).step_by(2) {
                    waves[k][m][0] += t[k][m] * plus;
                    waves[k][m][1] += t[k][m] * minus;
                }
            }
        }
        for (k, factorial) in [1.0, 1.0, 2.0, 6.0, 24.0].into_iter().enumerate() {
            waves[k] = waves[k].map(|w| w.map(|x| x / factorial));
        }
        Self { c: polynomial(&in_principal_axes(waves)) }
    }
}

type Waves = [[[f64; 2]; 5]; 5];

/// Turns the plane until the second-order wave `m = 2` is `+cos 2φ` alone.
fn in_principal_axes(mut waves: Waves) -> Waves {
    let [c, s] = waves[2][2];
    let double = CosSin::of_vector(c / c.hypot(s).max(f64::MIN_POSITIVE), s / c.hypot(s).max(f64::MIN_POSITIVE));
    // Half the angle: cos² = (1 + cos 2α)/2 without cancellation.
    let (a, b) = if double.cos >= 0.0 {
        (1.0 + double.cos, double.sin)
    } else {
        (double.sin.abs(), (1.0 - double.cos).copysign(double.sin))
    };
    let turn = CosSin::of_vector(0.5 * a, 0.5 * b);
    let (mut cos, mut sin) = (1.0, 0.0);
    for m in 0..5 {
        for row in &mut waves {
            let [c, s] = row[m];
            row[m] = [c * cos + s * sin, s * cos - c * sin];
        }
        (cos, sin) = (turn.cos * cos - turn.sin * sin, turn.sin * cos + turn.cos * sin);
    }
    waves
}

/// The waves as terms of a polynomial.
fn polynomial(waves: &Waves) -> [[f64; 5]; 5] {
    let w = |k: usize, m: usize| waves[k][m];
    let mut c = [[0.0; 5]; 5];
    c[0][0] = w(0, 0)[0];
    [c[1][0], c[0][1]] = w(1, 1);
    let ([c20, _], [c22, _]) = (w(2, 0), w(2, 2));
    (c[2][0], c[0][2]) = (c20 + c22, c20 - c22);
    let ([c31, s31], [c33, s33]) = (w(3, 1), w(3, 3));
    (c[3][0], c[2][1]) = (c31 + c33, s31 + 3.0 * s33);
    (c[1][2], c[0][3]) = (c31 - 3.0 * c33, s31 - s33);
    let ([c40, _], [c42, s42], [c44, s44]) = (w(4, 0), w(4, 2), w(4, 4));
    (c[4][0], c[0][4]) = (c40 + c42 + c44, c40 - c42 + c44);
    (c[3][1], c[1][3]) = (2.0 * s42 + 4.0 * s44, 2.0 * s42 - 4.0 * s44);
    c[2][2] = 2.0 * c40 - 6.0 * c44;
    c
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::basis::Basis;
    use crate::basis::eval_basis;
    use crate::basis::second_order::second_order;
    use crate::expansion::{Expansion as _, ShVec};
    use crate::sphere::Dir;
    use lobe_testkit::{Random, directions};

    #[test]
    fn derivatives_at_the_pole_are_those_of_the_basis() {
        let table = PoleDerivatives::new(9);
        for l in 0..9 {
            // The series, to the order that is left out: θ⁶ l⁶/720 √((2l+1)/4π)
            let theta = 0.02_f64;
            let y = eval_basis(Dir::from_angles(theta, 0.0), l + 1);
            for m in 0..DERIVATIVES.min(l + 1) {
                let mut sum = 0.0;
                let mut power = 1.0;
                for k in 0..DERIVATIVES {
                    sum += power * table.bands[l][k][m];
                    power *= theta / (k + 1) as f64;
                }
                let value = y[l * (l + 1) + m];
                let left = 2.0 * (theta * l as f64).powi(6) / 720.0;
                assert!((sum - value).abs() < left + 1e-15, "band {l}, m {m}: {sum} against {value}");
            }
        }
    }

    #[test]
    fn the_polynomial_is_the_function_but_for_its_fifth_derivative() {
        for order in [4, 6, 9, 13] {
            let f = ShVec::from_vec(Random::new(order as u64).signed_vec(order * order)).unwrap();
            PoleDerivatives::with_shared(order, |table| {
                let bound = table.bounds(f.coefficients())[5];
                let mut work = vec![0.0; order * order];
                for s in directions() {
                    let Taylor { c } = Taylor::new(table, f.coefficients(), s, &mut work);
                    let [local] = Basis::<f64>::with_shared(order, |basis| second_order(basis, f.coefficients(), &[s]));
                    let ([low, high], _, [b, a]) = local.principal_curvatures();
                    assert!((local.value - c[0][0]).abs() < 1e-12, "value {} against {}", c[0][0], local.value);
                    let curvatures = (2.0 * c[0][2] - low).abs().max((2.0 * c[2][0] - high).abs());
                    assert!(
                        curvatures < 1e-10 && c[1][1] == 0.0,
                        "order {order} at {s:?}: curvatures {curvatures} off"
                    );
                    // The axes are known but for their signs, which the slopes fix here.
                    let slope = |t: [f64; 2]| t[0] * local.gradient[0] + t[1] * local.gradient[1];
                    let (sign_a, sign_b) = (slope(a) * c[1][0], slope(b) * c[0][1]);
                    let (a, b) = (a.map(|x| x.copysign(x * sign_a)), b.map(|x| x.copysign(x * sign_b)));
                    let radius: f64 = 0.3 / order as f64;
                    for k in 0..12 {
                        let (sin, cos) = f64::from(k).sin_cos();
                        let (u, v) = (radius * cos, radius * sin);
                        let value = f.eval(Dir::from_unit(local.step([0, 1].map(|i| u * a[i] + v * b[i]))));
                        let sum: f64 = (0..5)
                            .map(|i| (0..5).map(|j| c[i][j] * u.powi(i as i32) * v.powi(j as i32)).sum::<f64>())
                            .sum();
                        let left = bound * radius.powi(5) / 120.0;
                        assert!(
                            (sum - value).abs() <= left + 1e-12,
                            "order {order} at {s:?}: {sum} against {value}, {left}"
                        );
                    }
                }
            });
        }
    }
}
