//! Non-linear evaluation of bands 0 and 1 that is never negative, after Geomerics.

use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::encoding::{LINEAR_SHARE, channel_of, coefficient, linear_vector, y_0};
use crate::expansion::{Expansion, Sh};
use crate::scalar::{Coefficient, Real};
use crate::sphere::Dir;
use crate::sphere::vector::dot;

/// Irradiance as bands 0 and 1 of each channel, evaluated with a power of the cosine in place of the linear term.
///
/// ```text
///   E(n) = π R_0 (a + (1 - a)(p + 1) q^p)        q = (1 + n·d)/2        p = 1 + 2r        a = (1 - r)/(1 + r)
///   R_0 = ⟨L⟩ = L_00/√(4π)        R_1 = ⟨L s⟩ = (-L_11, -L_1-1, L_10)/√(12π)        r = |R_1|/R_0        d = R_1/|R_1|
/// ```
///
/// `⟨ ⟩` is the mean over the sphere of the radiance `L`, so that `r <= 1` for every light. With these the mean of `E`
/// is kept exactly, a constant is a constant, and a single directional light has the right peak, `4π R_0` (tests
/// `the_mean_is_kept_exactly`, `a_constant_stays_a_constant`, `one_light_has_its_peak_and_is_dark_behind`). With
/// orthonormal coefficients in place of `R_0` and `R_1`, as in several shaders, a white sky is 1.128 in place of 1. The
/// mean of `E s` is exact at `r = 1/2` and 10 % too small at `r = 1`. After the diffuse reconstruction of Geomerics
/// (Hazel 2015).
///
/// Never negative. `r` is limited to 1, which no expansion of non-negative light exceeds. A channel whose mean
/// is zero or below is 0 everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NonLinearL1<T = f32> {
    /// Bands 0 and 1 of the irradiance.
    pub linear: Sh<4, T>,
}

impl<T: Coefficient> NonLinearL1<T> {
    /// Keeps the first two bands of an irradiance.
    #[must_use]
    pub fn from_irradiance_sh(irradiance: &impl Expansion<T>) -> Self {
        Self { linear: Sh::from_slice(irradiance.coefficients()) }
    }

    /// The irradiance of a surface with normal `n`.
    #[must_use]
    pub fn eval(&self, n: Dir) -> T {
        let (mean, vector) = (coefficient(&self.linear, 0), linear_vector(&self.linear));
        T::from_channels(|c| T::Scalar::from_f64(eval_channel(mean.channel(c), channel_of(vector, c), n)))
    }
}

/// One channel, from the coefficients of the irradiance.
fn eval_channel(e_0: f64, e_1: [f64; 3], n: Dir) -> f64 {
    let r_0 = e_0 * y_0() / PI;
    if r_0 <= 0.0 {
        return 0.0;
    }
    let to_radiance = 1.0 / (PI * LINEAR_SHARE);
    let r_1 = e_1.map(|e| e * to_radiance / (12.0 * PI).sqrt());
    let length = dot(r_1, r_1).sqrt();
    // Not `min`, which would hide a NaN.
    let r = if length > r_0 { 1.0 } else { length / r_0 };
    let cosine = if length == 0.0 { 0.0 } else { dot(r_1, n.to_array()) / length };
    let (p, a) = (1.0 + 2.0 * r, (1.0 - r) / (1.0 + r));
    // Rounding may leave the cosine a little below -1, and a negative number has no power.
    let q = if cosine < -1.0 { 0.0 } else { 0.5 * (1.0 + cosine) };
    PI * r_0 * (a + (1.0 - a) * (p + 1.0) * q.powf(p))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::{ShL1, Zonal};
    use crate::rotation::Rotation;
    use crate::scalar::Rgb;
    use crate::sphere::quadrature::SphereQuadrature;
    use lobe_testkit::{Random, directions};

    /// The irradiance of an impulse of strength `k` and of the constant radiance `a`.
    fn light(k: f64, a: f64, towards: Dir) -> NonLinearL1<f64> {
        let impulse = Zonal::clamped_cosine(2).towards(towards, k);
        let mut e = Sh::from_slice(impulse.coefficients());
        e += ShL1::constant(PI * a);
        NonLinearL1 { linear: e }
    }

    #[test]
    fn a_constant_stays_a_constant() {
        let white = NonLinearL1::from_irradiance_sh(&ShL1::constant(Rgb::new(PI, 0.5, 0.0)));
        for v in directions() {
            let e = white.eval(Dir::from_unit(v));
            let exact = (e.r / PI - 1.0).abs() < 1e-15 && (e.g - 0.5).abs() < 1e-15 && e.b == 0.0;
            assert!(exact, "towards {v:?}: {e:?}; white is 1, not 1.128");
        }
    }

    #[test]
    fn the_mean_is_kept_exactly() {
        let rule = SphereQuadrature::of_degree(400);
        for k in 1..=10 {
            let r = 0.1 * f64::from(k);
            // |R_1| = r k/4π and R_0 = k/4π for a share r of the light in the impulse.
            let f = light(4.0 * PI * r, 1.0 - r, Dir::from_angles(0.9, 2.0));
            let mean = rule.integrate(|n| f.eval(n)) / (4.0 * PI);
            assert!((mean - PI).abs() < 1e-5, "r = {r}: mean {mean} against π");
        }
    }

    #[test]
    fn the_first_moment_is_nearly_kept() {
        // (r, ⟨E/π n·d⟩); exact would be 2r/3.
        for (r, expected) in [(0.5, 0.33333), (0.8, 0.502), (1.0, 0.600)] {
            let f = light(4.0 * PI * r, 1.0 - r, Dir::Y);
            let moment = SphereQuadrature::of_degree(400).integrate(|n| f.eval(n) * n.y()) / (4.0 * PI * PI);
            assert!((moment - expected).abs() < 5e-4, "r = {r}: {moment} against {expected}");
        }
    }

    #[test]
    fn one_light_has_its_peak_and_is_dark_behind() {
        for v in directions() {
            let d = Dir::from_unit(v);
            let f = light(1.0, 0.0, d);
            let (front, back) = (f.eval(d), f.eval(-d));
            assert!((front - 1.0).abs() < 1e-14 && (0.0..1e-14).contains(&back), "{v:?}: {front} and {back}");
        }
    }

    #[test]
    fn it_is_never_negative_and_turns_with_the_light() {
        let mut random = Random::new(3);
        for _ in 0..50 {
            let e = Sh::<4, f64>::from_slice(&random.signed_vec(4));
            let turn = Rotation::from_quaternion(random.quaternion()).unwrap();
            let (f, g) = (NonLinearL1 { linear: e }, NonLinearL1 { linear: e.rotated(&turn) });
            for v in directions() {
                let s = Dir::from_unit(v);
                let (a, b) = (f.eval(s), g.eval(turn.rotate_dir(s)));
                assert!(a >= 0.0 && (a - b).abs() < 1e-13, "{e:?} towards {v:?}: {a}, turned {b}");
            }
        }
    }

    #[test]
    fn no_light_is_dark_and_nan_shows() {
        let zero = NonLinearL1::<f64> { linear: Sh::zero() };
        assert_eq!(zero.eval(Dir::X), 0.0, "no light");
        let negative = NonLinearL1 { linear: ShL1::constant(-1.0) };
        assert_eq!(negative.eval(Dir::X), 0.0, "negative light");
        let nan = NonLinearL1 { linear: Sh::from([Rgb::new(1.0, f64::NAN, 1.0); 4]) };
        let e = nan.eval(Dir::X);
        assert!(e.r.is_finite() && e.g.is_nan() && e.b.is_finite(), "{e:?}");
    }
}
