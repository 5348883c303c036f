//! Preetham sky model for clear skies.

use std::f64::consts::PI;

use lobe_sh::{Coefficient, Dir, Rgb};

use crate::error::EnvError;
use crate::sky::sky::Sky;

/// The range of turbidities of the model: from a very clear sky to haze.
const TURBIDITIES: std::ops::RangeInclusive<f64> = 2.0..=10.0;

/// The least cosine of the zenith angle that enters `e^{B/cos θ}`: the ratio has no limit at the horizon for `B > 0`,
/// and the golden values were made with this floor.
const LEAST_COSINE: f64 = 0.01;

/// A clear sky by the formula of [Preetham, Shirley and Smits 1999], in kcd/m² (`Y`), as linear Rec. 709 color.
///
/// ```text
///   Y, x, y = zenith value · F(θ, γ)/F(0, θ_sun)        θ from the zenith, γ from the sun
///   F(θ, γ) = (1 + A e^{B/cos θ}) (1 + C e^{Dγ} + E cos²γ)
///
///   Y_z = (4.0453 T - 4.9710) tan χ - 0.2155 T + 2.4192        χ = (4/9 - T/120) (π - 2 θ_sun)
/// ```
///
/// `A` to `E` are linear in the turbidity `T`, the zenith chromaticities quadratic in `T` and cubic in `θ_sun`
/// (appendix A.2 of the paper). `T = 2` is a very clear sky, 10 haze. `cos θ` is clamped to at least 0.01. Luminance
/// and chromaticity are converted with the white D65; saturated blue may lie outside the gamut: a channel is then
/// negative and is not clamped, because expansions are linear. For radiance in W m⁻² sr⁻¹ divide by 0.683 lm/mW.
///
/// The model holds while the sun is above the horizon, and does not include its disc.
///
/// [Preetham, Shirley and Smits 1999]: https://doi.org/10.1145/311535.311545
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreethamSky {
    sun: Dir,
    turbidity: f64,
    /// Distributions of `Y`, `x` and `y`.
    distributions: [Distribution; 3],
    /// `zenith value / F(0, θ_sun)` of each.
    scales: [f64; 3],
}

impl PreethamSky {
    /// The sky of this turbidity, in `[2, 10]`, with the sun in the direction `sun`.
    ///
    /// # Errors
    /// [`EnvError::Options`] for any other turbidity, or a sun below the horizon.
    pub fn new(turbidity: f64, sun: Dir) -> Result<Self, EnvError> {
        if !TURBIDITIES.contains(&turbidity) {
            return Err(EnvError::Options(format!("a turbidity in [2, 10] expected, found {turbidity}")));
        }
        check_sun(sun)?;
        let theta = sun.theta();
        let distributions = DISTRIBUTIONS.map(|rows| Distribution::new(rows, turbidity));
        let zenith = [
            zenith_luminance(turbidity, theta),
            zenith_chromaticity(&ZENITH_X, turbidity, theta),
            zenith_chromaticity(&ZENITH_Y, turbidity, theta),
        ];
        let scales = std::array::from_fn(|k| zenith[k] / distributions[k].value(1.0, theta));
        Ok(Self { sun, turbidity, distributions, scales })
    }

    /// The turbidity.
    #[must_use]
    pub fn turbidity(&self) -> f64 {
        self.turbidity
    }

    /// The luminance of the zenith in kcd/m².
    #[must_use]
    pub fn zenith_luminance(&self) -> f64 {
        zenith_luminance(self.turbidity, self.sun.theta())
    }
}

impl Sky for PreethamSky {
    fn sun(&self) -> Dir {
        self.sun
    }

    fn radiance(&self, s: Dir) -> Rgb<f64> {
        if s.z() < 0.0 {
            return Rgb::ZERO;
        }
        let gamma = s.angle_to(self.sun);
        let [luminance, x, y]: [f64; 3] =
            std::array::from_fn(|k| self.scales[k] * self.distributions[k].value(s.z(), gamma));
        rgb_from_xyz([x / y * luminance, luminance, (1.0 - x - y) / y * luminance])
    }

    fn breaks(&self) -> Vec<f64> {
        vec![LEAST_COSINE.acos()]
    }
}

/// Fails if the sun is below the horizon.
pub(crate) fn check_sun(sun: Dir) -> Result<(), EnvError> {
    // The rounding of π/2 may put a sun on the horizon a hair below it.
    if sun.z() < -1e-15 {
        let below = (-sun.z()).asin().to_degrees();
        return Err(EnvError::Options(format!("a sun above the horizon expected, found {below}° below it")));
    }
    Ok(())
}

/// Slope and offset in `T` of `A` to `E`, for `Y`, `x` and `y`: appendix A.2 of the paper.
const DISTRIBUTIONS: [[[f64; 2]; 5]; 3] = [
    [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]],
    [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]],
    [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]],
];

/// The zenith's `x`: rows for `T²`, `T`, 1; columns for `θ³`, `θ²`, `θ`, 1 (appendix A.2).
const ZENITH_X: [[f64; 4]; 3] =
    [[0.00166, -0.00375, 0.00209, 0.0], [-0.02903, 0.06377, -0.03202, 0.00394], [0.11693, -0.21196, 0.06052, 0.25886]];

/// The zenith's `y`.
const ZENITH_Y: [[f64; 4]; 3] =
    [[0.00275, -0.00610, 0.00317, 0.0], [-0.04214, 0.08970, -0.04153, 0.00516], [0.15346, -0.26756, 0.06670, 0.26688]];

/// `F` of one of `Y`, `x`, `y`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Distribution {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
    e: f64,
}

impl Distribution {
    fn new(rows: [[f64; 2]; 5], turbidity: f64) -> Self {
        let [a, b, c, d, e] = rows.map(|[slope, offset]| slope * turbidity + offset);
        Self { a, b, c, d, e }
    }

    fn value(&self, cos_theta: f64, gamma: f64) -> f64 {
        let cos_gamma = gamma.cos();
        (1.0 + self.a * (self.b / cos_theta.max(LEAST_COSINE)).exp())
            * (1.0 + self.c * (self.d * gamma).exp() + self.e * cos_gamma * cos_gamma)
    }
}

/// `Y_z / F(0, θ_sun)`: the factor of the luminance of every direction.
pub(crate) fn luminance_scale(turbidity: f64, theta_sun: f64) -> f64 {
    zenith_luminance(turbidity, theta_sun) / Distribution::new(DISTRIBUTIONS[0], turbidity).value(1.0, theta_sun)
}

/// `Y_z` in kcd/m².
fn zenith_luminance(turbidity: f64, theta_sun: f64) -> f64 {
    let chi = (4.0 / 9.0 - turbidity / 120.0) * (PI - 2.0 * theta_sun);
    (4.0453 * turbidity - 4.9710) * chi.tan() - 0.2155 * turbidity + 2.4192
}

fn zenith_chromaticity(rows: &[[f64; 4]; 3], turbidity: f64, theta_sun: f64) -> f64 {
    let horner = |polynomial: &[f64], x: f64| polynomial.iter().fold(0.0, |sum, c| sum * x + c);
    horner(&rows.map(|row| horner(&row, theta_sun)), turbidity)
}

/// `X, Y, Z` of the illuminant D65 for the observer of 2°, to the digits of the usual sRGB matrices (its rounded
/// chromaticity (0.3127, 0.3290) would move the golden values by up to 6e-3).
const WHITE: [f64; 3] = [0.95047, 1.0, 1.08883];

/// Linear Rec. 709 from CIE XYZ, from the primaries and the white.
fn rgb_from_xyz(xyz: [f64; 3]) -> Rgb<f64> {
    const RGB_FROM_XYZ: [[f64; 3]; 3] = invert(xyz_from_rgb());
    Rgb::from(RGB_FROM_XYZ.map(|row| row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2]))
}

/// The matrix whose columns are the primaries, scaled so that they add up to the white.
const fn xyz_from_rgb() -> [[f64; 3]; 3] {
    let columns = [xyz_of_chromaticity(0.64, 0.33), xyz_of_chromaticity(0.30, 0.60), xyz_of_chromaticity(0.15, 0.06)];
    let mut matrix = [[0.0; 3]; 3];
    let mut i = 0;
    while i < 9 {
        matrix[i / 3][i % 3] = columns[i % 3][i / 3];
        i += 1;
    }
    let inverse = invert(matrix);
    let mut i = 0;
    while i < 9 {
        let row = inverse[i % 3];
        matrix[i / 3][i % 3] *= row[0] * WHITE[0] + row[1] * WHITE[1] + row[2] * WHITE[2];
        i += 1;
    }
    matrix
}

/// `X, Y, Z` of chromaticity `(x, y)` with `Y = 1`.
const fn xyz_of_chromaticity(x: f64, y: f64) -> [f64; 3] {
    [x / y, 1.0, (1.0 - x - y) / y]
}

/// The inverse of a matrix, by cofactors.
const fn invert(m: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut cofactors = [[0.0; 3]; 3];
    let mut i = 0;
    while i < 9 {
        let (r, c) = (i / 3, i % 3);
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        cofactors[c][r] = m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
        i += 1;
    }
    let determinant = m[0][0] * cofactors[0][0] + m[0][1] * cofactors[1][0] + m[0][2] * cofactors[2][0];
    let mut i = 0;
    while i < 9 {
        cofactors[i / 3][i % 3] /= determinant;
        i += 1;
    }
    cofactors
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sky::sky::{Ground, sky_sh};

    #[test]
    fn the_golden_sky_of_turbidity_three_has_its_coefficients() {
        // The rule behind the golden values is not known; they differ from ours by up to 1.02e-4, about as an impulse
        // of 2e-4 at the sun would, while `the_projection_of_skies_has_converged` holds ours to 1e-8.
        const TIP: f64 = 1.1e-4;
        const RED: [f64; 9] = [13.186399, 0.0, 10.085359, -6.232158, 0.0, 0.0, -2.461094, -6.069577, 2.947742];
        const GREEN: [f64; 9] = [17.031973, 0.0, 14.310098, -5.865224, 0.0, 0.0, -1.074418, -6.143088, 2.705840];
        const BLUE: [f64; 9] = [26.533365, 0.0, 24.214440, -7.307663, 0.0, 0.0, 1.785062, -8.181693, 2.988082];
        let sky = PreethamSky::new(3.0, Dir::from_angles(PI / 4.0, 0.0)).unwrap();
        assert!((sky.zenith_luminance() - 7.320358316713676).abs() < 1e-13, "{}", sky.zenith_luminance());
        let f = sky_sh(&sky, &Ground::default(), 3);
        for i in 0..9 {
            for (found, expected) in f[i].to_array().into_iter().zip([RED[i], GREEN[i], BLUE[i]]) {
                assert!((found - expected).abs() < TIP, "coefficient {i}: {found} against {expected}");
            }
        }
    }

    #[test]
    fn white_is_white_and_the_luminance_of_a_color_is_its_y() {
        let white = rgb_from_xyz(WHITE);
        for channel in white.to_array() {
            assert!((channel - 1.0).abs() < 1e-14, "{white:?}");
        }
        let found = rgb_from_xyz([0.3, 0.5, 0.7]).luminance();
        assert!((found - 0.5).abs() < 1e-4, "{found}: BT.709 rounds the weights to four digits");
    }

    #[test]
    fn the_zenith_has_the_luminance_of_the_formula() {
        for theta in [0.0, 0.5, 1.2, 1.5] {
            let sky = PreethamSky::new(4.0, Dir::from_angles(theta, 1.0)).unwrap();
            let found = sky.radiance(Dir::Z).luminance();
            assert!((found / sky.zenith_luminance() - 1.0).abs() < 1e-3, "sun at {theta}: {found}");
        }
    }

    #[test]
    fn the_sky_is_brightest_near_the_sun_and_blue_opposite_to_it() {
        let sky = PreethamSky::new(3.0, Dir::from_angles(1.0, 0.0)).unwrap();
        let (near, opposite) = (sky.radiance(Dir::from_angles(1.0, 0.05)), sky.radiance(Dir::from_angles(0.6, PI)));
        assert!(near.luminance() > 3.0 * opposite.luminance(), "{near:?} {opposite:?}");
        assert!(opposite.b > 1.5 * opposite.r, "{opposite:?}");
        assert_eq!(sky.radiance(-Dir::Z), Rgb::ZERO, "below the horizon");
    }

    #[test]
    fn a_sun_below_the_horizon_and_odd_turbidities_are_refused() {
        assert!(PreethamSky::new(3.0, Dir::from_angles(1.6, 0.0)).is_err(), "sun below the horizon");
        assert!(PreethamSky::new(3.0, Dir::from_angles(std::f64::consts::FRAC_PI_2, 3.0)).is_ok(), "sun on it");
        for turbidity in [1.0, 11.0, f64::NAN] {
            assert!(PreethamSky::new(turbidity, Dir::Z).is_err(), "turbidity {turbidity}");
        }
    }
}
