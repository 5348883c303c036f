//! Legendre polynomials and associated Legendre functions.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// The associated Legendre function `P_l^m(z)` with the Condon-Shortley phase, for `0 <= m <= l` and `|z| <= 1`.
///
/// ```text
///   P_l^m(z) = (-1)^m (1 - z²)^{m/2} d^m/dz^m P_l(z)
///
///   P_m^m = (1 - 2m) √(1 - z²) P_{m-1}^{m-1}        P_{m+1}^m = (2m + 1) z P_m^m
///   P_l^m = ((2l - 1) z P_{l-1}^m - (l + m - 1) P_{l-2}^m) / (l - m)
/// ```
///
/// Zero for `m > l`, NaN for `|z| > 1`. Not normalized: it overflows from `l = m = 151` on (test
/// `the_plain_function_is_finite_to_degree_150`); [`legendre_normalized`] does not. Source: [Sloan 2008] A1; DLMF
/// 14.10.3.
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
#[must_use]
pub fn legendre(l: usize, m: usize, z: f64) -> f64 {
    if m > l {
        return 0.0;
    }
    let sin_theta = ((1.0 - z) * (1.0 + z)).sqrt();
    let mut p = (1..=m).fold(1.0, |p, m| p * (1.0 - 2.0 * m as f64) * sin_theta);
    let mut before = 0.0;
    for k in m + 1..=l {
        let (kf, mf) = (k as f64, m as f64);
        (before, p) = (p, ((2.0 * kf - 1.0) * z * p - (kf + mf - 1.0) * before) / (kf - mf));
    }
    p
}

/// The associated Legendre function normalized for the complex basis, Condon-Shortley phase included.
///
/// ```text
///   N_l^m P_l^m(cos θ)        N_l^m = √((2l+1)/(4π) (l-m)!/(l+m)!)        Y_l^m = N_l^m P_l^m(cos θ) e^{imφ}
/// ```
///
/// For `0 <= m <= l`; zero for `m > l`. No factorial is formed: with `P̄ = N P`,
///
/// ```text
///   P̄_m^m = -√((2m+1)/(2m)) sin θ P̄_{m-1}^{m-1}        P̄_0^0 = 1/√(4π)
///   P̄_l^m = a_l z P̄_{l-1}^m - (a_l/a_{l-1}) P̄_{l-2}^m        a_l = √((4l² - 1)/(l² - m²))
/// ```
#[must_use]
pub fn legendre_normalized(l: usize, m: usize, z: f64) -> f64 {
    legendre_normalized_at(l, m, ((1.0 - z) * (1.0 + z)).sqrt(), z)
}

/// [`legendre_normalized`] from both `sin θ` and `z = cos θ`: near the poles `z` alone does not hold the digits of
/// the angle.
pub(crate) fn legendre_normalized_at(l: usize, m: usize, sin_theta: f64, z: f64) -> f64 {
    if m > l {
        return 0.0;
    }
    let mut p = (4.0 * core::f64::consts::PI).sqrt().recip();
    for k in 1..=m {
        p *= -((2 * k + 1) as f64 / (2 * k) as f64).sqrt() * sin_theta;
    }
    let (mut before, mut a_before) = (0.0, f64::INFINITY);
    for k in m + 1..=l {
        let a = ((4 * k * k - 1) as f64 / (k * k - m * m) as f64).sqrt();
        (before, p) = (p, a * z * p - a / a_before * before);
        a_before = a;
    }
    p
}

/// The Legendre polynomials `P_0(t) .. P_{count-1}(t)`.
pub(crate) fn legendre_all(count: usize, t: f64) -> impl Iterator<Item = f64> {
    let (mut before, mut p) = (0.0, 1.0);
    (0..count).map(move |l| {
        let value = p;
        let lf = l as f64;
        (before, p) = (p, ((2.0 * lf + 1.0) * t * p - lf * before) / (lf + 1.0));
        value
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEIGHTS: [f64; 9] = [-1.0, -0.999999, -0.7, -0.2, 0.0, 0.3, 0.8, 0.999999, 1.0];

    #[test]
    fn low_degrees_are_their_textbook_polynomials() {
        for z in HEIGHTS {
            let r = (1.0 - z * z).sqrt();
            let expected = [
                (0, 0, 1.0),
                (1, 0, z),
                (1, 1, -r),
                (2, 0, 0.5 * (3.0 * z * z - 1.0)),
                (2, 1, -3.0 * z * r),
                (2, 2, 3.0 * r * r),
                (3, 1, -1.5 * (5.0 * z * z - 1.0) * r),
                (3, 3, -15.0 * r * r * r),
                (4, 2, 7.5 * (7.0 * z * z - 1.0) * r * r),
            ];
            for (l, m, value) in expected {
                let p = legendre(l, m, z);
                assert!((p - value).abs() < 1e-13, "P_{l}^{m}({z}): {p} against {value}");
            }
        }
    }

    #[test]
    fn the_normalized_function_is_the_plain_one_times_its_norm() {
        for l in 0..20 {
            for m in 0..=l {
                let ratio: f64 = (l - m + 1..=l + m).map(|k| k as f64).product();
                let norm = ((2 * l + 1) as f64 / (4.0 * core::f64::consts::PI) / ratio).sqrt();
                for z in HEIGHTS {
                    let (p, q) = (legendre_normalized(l, m, z), norm * legendre(l, m, z));
                    assert!((p - q).abs() < 1e-13, "l {l}, m {m}, z {z}: {p} against {q}");
                }
            }
        }
    }

    #[test]
    fn the_real_basis_at_azimuth_zero_is_the_normalized_function() {
        for z in HEIGHTS {
            let y = crate::eval_basis(crate::Dir::from_unit([((1.0 - z) * (1.0 + z)).sqrt(), 0.0, z]), 40);
            for l in 0..40 {
                for m in 0..=l {
                    let factor = if m == 0 { 1.0 } else { 2.0_f64.sqrt() };
                    let (a, b) =
                        (y[crate::basis::coefficient_index(l, m as isize)], factor * legendre_normalized(l, m, z));
                    assert!((a - b).abs() < 1e-13, "l {l}, m {m}, z {z}: {a} against {b}");
                }
            }
        }
    }

    #[test]
    fn high_degrees_do_not_overflow() {
        for (l, m) in [(86, 86), (200, 100), (1000, 1000), (2000, 3)] {
            let p = legendre_normalized(l, m, 0.3);
            assert!(p.is_finite() && p.abs() < 10.0, "l {l}, m {m}: {p}");
        }
    }

    #[test]
    fn the_plain_function_is_finite_to_degree_150() {
        for m in 0..=150 {
            for z in HEIGHTS {
                let p = legendre(150, m, z);
                assert!(p.is_finite(), "P_150^{m}({z}) = {p}");
            }
        }
        assert_eq!(legendre(151, 151, 0.0), f64::NEG_INFINITY, "P_151^151(0)");
        assert!(legendre(3, 1, 1.5).is_nan() && legendre_normalized(3, 1, -1.5).is_nan(), "outside of [-1, 1]");
    }

    #[test]
    fn functions_above_the_degree_are_zero() {
        assert_eq!((legendre(2, 3, 0.4), legendre_normalized(2, 3, 0.4)), (0.0, 0.0), "m > l");
    }

    #[test]
    fn neighboring_degrees_satisfy_the_recurrence_of_legendre() {
        let p: Vec<f64> = legendre_all(50, 0.37).collect();
        for (l, value) in p.iter().enumerate() {
            assert!((value - legendre(l, 0, 0.37)).abs() < 1e-14, "P_{l}: {value}");
        }
    }
}
