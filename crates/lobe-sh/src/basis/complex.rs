//! The complex spherical harmonics and the map to and from the real ones.

use crate::basis::index::{coefficient_count, coefficient_index, order_of_slice};
use crate::basis::legendre::legendre_normalized_at;
use crate::prelude::*;
use crate::sphere::Dir;

/// The complex basis function `Y_l^m(s)`, orthonormal, with the Condon-Shortley phase: its real and its imaginary part.
///
/// ```text
///   Y_l^m = √((2l+1)/(4π) (l-m)!/(l+m)!) P_l^m(cos θ) e^{imφ}        Y_l^-m = (-1)^m conj(Y_l^m)
/// ```
///
/// The phase stands once, inside `P_l^m` ([`legendre`](crate::basis::legendre())); lecture notes that give it in the
/// definition of `Y` and in `P` as well contradict their own tables.
///
/// # Panics
/// If `|m| > l`.
#[must_use]
pub fn eval_complex(l: usize, m: isize, s: Dir) -> [f64; 2] {
    let k = m.unsigned_abs();
    assert!(k <= l, "m = {m} lies outside band {l}");
    let norm = legendre_normalized_at(l, k, s.x().hypot(s.y()), s.z());
    let (sin, cos) = (k as f64 * s.phi()).sin_cos();
    if m < 0 { conjugate([norm * cos, norm * sin], k) } else { [norm * cos, norm * sin] }
}

/// The coefficients in the complex basis, real and imaginary part, of a function given in the real one.
///
/// ```text
///   c_l0 = f_l0        c_lm = (f_lm - i f_l-m)/√2        c_l-m = (-1)^m (f_lm + i f_l-m)/√2        m > 0
/// ```
///
/// Index order `i = l(l+1) + m`. The map is unitary.
///
/// # Panics
/// If `real` are not `n²`.
#[must_use]
pub fn complex_from_real(real: &[f64]) -> Vec<[f64; 2]> {
    let order = order_of_slice(real);
    let mut complex = vec![[0.0; 2]; coefficient_count(order)];
    for l in 0..order {
        complex[coefficient_index(l, 0)] = [real[coefficient_index(l, 0)], 0.0];
        for m in 1..=l as isize {
            let (plus, minus) = (real[coefficient_index(l, m)], real[coefficient_index(l, -m)]);
            let c = [plus, -minus].map(|part| part * 0.5_f64.sqrt());
            complex[coefficient_index(l, m)] = c;
            complex[coefficient_index(l, -m)] = conjugate(c, m.unsigned_abs());
        }
    }
    complex
}

/// The coefficients in the real basis of the real part of a function given in the complex one.
///
/// ```text
///   f_l0 = Re c_l0        f_lm = Re(c_lm + (-1)^m c_l-m)/√2        f_l-m = -Im(c_lm - (-1)^m c_l-m)/√2        m > 0
/// ```
///
/// A real function has `c_l-m = (-1)^m conj(c_lm)`, and then nothing is lost.
///
/// # Panics
/// If `complex` are not `n²`.
#[must_use]
pub fn real_from_complex(complex: &[[f64; 2]]) -> Vec<f64> {
    let order = order_of_slice(complex);
    let mut real = vec![0.0; coefficient_count(order)];
    for l in 0..order {
        real[coefficient_index(l, 0)] = complex[coefficient_index(l, 0)][0];
        for m in 1..=l as isize {
            let plus = complex[coefficient_index(l, m)];
            let minus = complex[coefficient_index(l, -m)].map(|part| part * sign(m.unsigned_abs()));
            real[coefficient_index(l, m)] = (plus[0] + minus[0]) * 0.5_f64.sqrt();
            real[coefficient_index(l, -m)] = -(plus[1] - minus[1]) * 0.5_f64.sqrt();
        }
    }
    real
}

/// `(-1)^m conj(c)`.
fn conjugate([re, im]: [f64; 2], m: usize) -> [f64; 2] {
    [re * sign(m), -im * sign(m)]
}

/// `(-1)^m`.
fn sign(m: usize) -> f64 {
    if m.is_multiple_of(2) { 1.0 } else { -1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::index::band_and_m;
    use crate::expansion::{Expansion as _, ShVec};
    use lobe_testkit::{Random, directions};
    use num_complex::Complex64;

    fn of([re, im]: [f64; 2]) -> Complex64 {
        Complex64::new(re, im)
    }

    /// `Σ c_lm Y_lm(s)`.
    fn eval(complex: &[[f64; 2]], s: Dir) -> Complex64 {
        complex.iter().enumerate().map(|(i, c)| of(*c) * of(eval_complex(band_and_m(i).0, band_and_m(i).1, s))).sum()
    }

    #[test]
    fn both_bases_give_a_function_the_same_values() {
        let f = ShVec::from_vec(Random::new(1).signed_vec(100)).unwrap();
        let complex = complex_from_real(f.coefficients());
        for v in directions() {
            let s = Dir::from_unit(v);
            let value = eval(&complex, s);
            assert!((value - f.eval(s)).norm() < 1e-12, "towards {v:?}: {value} against {}", f.eval(s));
        }
    }

    #[test]
    fn the_map_round_trips_and_keeps_the_energy() {
        let real = Random::new(2).signed_vec(64 * 64);
        let complex = complex_from_real(&real);
        let (a, b): (f64, f64) = (real.iter().map(|f| f * f).sum(), complex.iter().map(|c| of(*c).norm_sqr()).sum());
        assert!((a / b - 1.0).abs() < 1e-13, "energies {a} and {b}");
        for (i, (a, b)) in real.iter().zip(real_from_complex(&complex)).enumerate() {
            assert!((a - b).abs() < 1e-15, "i {i}: {a} became {b}");
        }
    }

    #[test]
    fn the_real_part_of_a_complex_function_is_kept() {
        let numbers = Random::new(3).signed_vec(50);
        let complex: Vec<[f64; 2]> = numbers.chunks(2).map(|c| [c[0], c[1]]).collect();
        let real = ShVec::from_vec(real_from_complex(&complex)).unwrap();
        for v in directions() {
            let s = Dir::from_unit(v);
            let (a, b) = (real.eval(s), eval(&complex, s).re);
            assert!((a - b).abs() < 1e-13, "towards {v:?}: {a} against {b}");
        }
    }

    #[test]
    fn textbook_functions_have_their_signs() {
        let s = Dir::from_angles(0.7, 1.9);
        let (sin, cos) = 0.7_f64.sin_cos();
        let pi = core::f64::consts::PI;
        let e = |k: f64| Complex64::from_polar(1.0, k * 1.9);
        let expected = [
            (1, 1, -(3.0 / (8.0 * pi)).sqrt() * sin * e(1.0)),
            (1, -1, (3.0 / (8.0 * pi)).sqrt() * sin * e(-1.0)),
            (2, 1, -(15.0 / (8.0 * pi)).sqrt() * sin * cos * e(1.0)),
            (2, -2, 0.25 * (15.0 / (2.0 * pi)).sqrt() * sin * sin * e(-2.0)),
        ];
        for (l, m, value) in expected {
            let y = of(eval_complex(l, m, s));
            assert!((y - value).norm() < 1e-15, "Y_{l}^{m}: {y} against {value}");
        }
    }
}
