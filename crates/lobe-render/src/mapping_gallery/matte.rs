//! Diffuse surfaces by irradiance maps, and by nine coefficients as a quadratic polynomial in the normal.

use std::f64::consts::PI;

use lobe_env::EnvMap;
use lobe_sh::{Coefficient, Dir, Expansion, Rgb};

use crate::{Shading, SurfacePoint};

/// A matte surface that looks its irradiance up by the normal.
///
/// ```text
///   L = albedo E(n)/π
/// ```
///
/// Irradiance is smooth: 32 x 16 texels are within 0.3 % (RMS) of brute force under the bundled sunset, within 2 %
/// under the studio, whose lamps are small and bright (test `matte_techniques_agree_with_brute_force`). Miller and
/// Hoffman 1984.
#[derive(Clone, Debug, PartialEq)]
pub struct MatteByMap {
    /// `E`, without `1/π`.
    pub irradiance: EnvMap,
    /// The albedo in `[0, 1]`.
    pub albedo: Rgb<f32>,
}

impl Shading for MatteByMap {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        self.albedo * self.irradiance.radiance(at.normal).scale(std::f32::consts::FRAC_1_PI)
    }
}

/// A matte surface whose irradiance is a polynomial of the second degree in the normal.
///
/// ```text
///   L = albedo E(n)/π        E of IrradiancePolynomial
/// ```
///
/// Nine coefficients in place of a map; the error is that of cutting the cosine after three bands: below 2 % (RMS)
/// under the bundled sunset, below 12 % under the studio (test `matte_techniques_agree_with_brute_force`). Where the
/// light is a single sun, `E` on the far side is a little negative; the shading shows it as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatteBySh {
    /// `E`.
    pub irradiance: IrradiancePolynomial,
    /// The albedo in `[0, 1]`.
    pub albedo: Rgb<f32>,
}

impl Shading for MatteBySh {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        self.albedo * Rgb::narrow(self.irradiance.eval(at.normal).scale(std::f64::consts::FRAC_1_PI))
    }
}

/// The irradiance of the first nine coefficients of the light, as a polynomial in the normal `n = (x, y, z)`.
///
/// ```text
///   E(n) = k₁ c₂₂ (x² - y²) + k₃ c₂₀ z² + k₄ c₀₀ - k₅ c₂₀
///        + 2 k₁ (c₂₋₂ xy + c₂₁ xz + c₂₋₁ yz) + 2 k₂ (c₁₁ x + c₁₋₁ y + c₁₀ z)
///
///   k₁ = √(15π)/16    k₂ = √(π/3)/2    k₃ = 3√(5π)/16    k₄ = √π/2    k₅ = √(5π)/16
/// ```
///
/// `c` are the coefficients in the basis of [Ramamoorthi and Hanrahan 2001], whose functions are positive multiples of
/// `x`, `y`, `z`, `xy`, `yz`, `xz`; Lobe's, which have the Condon-Shortley phase, differ by the sign of `c₁±₁` and
/// `c₂±₁`. Each `k` is a constant of the basis times the factor `A_l = π, 2π/3, π/4` of the clamped cosine:
///
/// ```text
///   k₁ = ½ A₂ √(15/(4π))    k₂ = ½ A₁ √(3/(4π))    k₃ = 3 k₅    k₄ = A₀/√(4π)    k₅ = ½ A₂ √(5/(4π))
/// ```
///
/// Published to six digits, 0.429043, 0.511664, 0.743125, 0.886227, 0.247708, of which the second and the third are one
/// unit too high in the last; [`constants`](IrradiancePolynomial::constants) has them exact. It equals the expansion of
/// the convolved light to rounding (test `the_polynomial_is_the_expansion_of_the_irradiance`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IrradiancePolynomial {
    /// `c` in the order `(l, m)` = (0, 0), (1, -1), (1, 0), (1, 1), (2, -2) to (2, 2).
    c: [Rgb<f64>; 9],
}

impl IrradiancePolynomial {
    /// `k₁` to `k₅`.
    #[must_use]
    pub fn constants() -> [f64; 5] {
        let (quadratic, fifth) = ((15.0 * PI).sqrt() / 16.0, (5.0 * PI).sqrt() / 16.0);
        [quadratic, 0.5 * (PI / 3.0).sqrt(), 3.0 * fifth, 0.5 * PI.sqrt(), fifth]
    }

    /// The polynomial of the radiance that `light` is the expansion of; bands above the third are left out, missing
    /// ones are zero.
    #[must_use]
    pub fn of_radiance<T: Coefficient<Wide = Rgb<f64>>>(light: &impl Expansion<T>) -> Self {
        /// The signs of the Condon-Shortley phase.
        const SIGNS: [f64; 9] = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0];
        let f = light.coefficients();
        Self { c: std::array::from_fn(|i| f.get(i).map_or(Rgb::ZERO, |f| f.widen().scale(SIGNS[i]))) }
    }

    /// The irradiance `E` of a surface that faces `n`.
    #[must_use]
    pub fn eval(&self, n: Dir) -> Rgb<f64> {
        let [k1, k2, k3, k4, k5] = Self::constants();
        let [c00, c1n1, c10, c11, c2n2, c2n1, c20, c21, c22] = self.c;
        let [x, y, z] = n.to_array();
        c22.scale(k1 * (x * x - y * y)) + c20.scale(k3 * z * z) + c00.scale(k4) - c20.scale(k5)
            + (c2n2.scale(x * y) + c21.scale(x * z) + c2n1.scale(y * z)).scale(2.0 * k1)
            + (c11.scale(x) + c1n1.scale(y) + c10.scale(z)).scale(2.0 * k2)
    }
}

#[cfg(test)]
mod tests {
    use lobe_sh::{ShVec, Zonal, convolve_in_place};
    use lobe_testkit::{Random, directions};

    use super::*;

    #[test]
    fn the_constants_are_the_published_ones_but_for_two_last_digits() {
        let published = [0.429043, 0.511664 - 1e-6, 0.743125 - 1e-6, 0.886227, 0.247708];
        for (k, (found, expected)) in IrradiancePolynomial::constants().iter().zip(published).enumerate() {
            assert!((found - expected).abs() <= 0.5e-6, "k{}: {found}, published {expected}", k + 1);
        }
    }

    #[test]
    fn the_polynomial_is_the_expansion_of_the_irradiance() {
        let mut random = Random::new(4);
        for order in [1, 2, 3, 5] {
            let light: Vec<Rgb<f64>> = (0..order * order).map(|_| Rgb::from_channels(|_| random.signed())).collect();
            let light = ShVec::from_vec(light).unwrap();
            let mut irradiance = light.resized(order.min(3));
            let cosine = Zonal::clamped_cosine(order.min(3));
            convolve_in_place(irradiance.coefficients_mut(), &cosine);
            let polynomial = IrradiancePolynomial::of_radiance(&light);
            for s in directions() {
                let n = Dir::new(s).unwrap();
                let (found, expected) = (polynomial.eval(n), irradiance.eval(n));
                let off = (found - expected).to_array().iter().fold(0.0_f64, |m, d| m.max(d.abs()));
                assert!(off < 5e-15, "order {order} towards {s:?}: {found:?} and {expected:?}");
            }
        }
    }

    #[test]
    fn even_light_gives_pi_times_its_radiance() {
        let e = IrradiancePolynomial::of_radiance(&ShVec::constant(3, Rgb::splat(1.0_f64))).eval(Dir::Y);
        assert!((e.g - PI).abs() < 1e-14, "{e:?}");
    }
}
