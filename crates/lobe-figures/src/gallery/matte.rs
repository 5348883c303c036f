//! Diffuse surfaces by irradiance maps, and by nine coefficients as a quadratic polynomial in the normal.

use lobe_env::EnvMap;
use lobe_sh::encoding::IrradiancePolynomial;
use lobe_sh::{Coefficient as _, Rgb};

use crate::gallery::exhibit::{Shading, SurfacePoint};

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
