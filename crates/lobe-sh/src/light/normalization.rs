//! The normalization of lights, and the irradiance of a surface that faces one.

use core::f64::consts::{FRAC_PI_2, PI};

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::expansion::Zonal;
use crate::expansion::zonal::zonal_norm;
use crate::light::cone::ease_sine;

/// The meaning of a light's color.
///
/// | | [`Projected`](Self::Projected) | [`Analytic`](Self::Analytic) | [`None`](Self::None) |
/// |---|---|---|---|
/// | a light of color 1 | makes a white Lambertian surface facing it reflect exactly 1, lit by the truncated expansion | the same, lit by the exact light | has radiance 1 inside its shape |
/// | directional | `4π/3`, `16π/17`, `16π/17`, `32π/31` .. times `y_i(dir)`, orders 2, 3, 4, 5 | `π y_i(dir)` | `y_i(dir)`: irradiance 1 |
/// | cone of half angle `a` | from its own bands | `1/sin² a`, 1 from 90° on | as it is |
///
/// The irradiance of a surface that faces a light with zonal coefficients `z_l` is `E = Σ_l A_l z_l K_l`, `A_l` that of
/// [`Zonal::clamped_cosine`]; `Projected` divides by `E/π` ([Sloan 2008], "Normalization").
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Normalization {
    /// From the truncated expansion, at its own order.
    #[default]
    Projected,
    /// From the light itself.
    Analytic,
    /// None: the radiance of the shape is 1; a directional light has irradiance 1.
    None,
}

impl Zonal {
    /// Light from the axis alone, of irradiance 1: `z_l = K_l = √((2l+1)/4π)`, all convolution factors 1.
    #[must_use]
    pub fn impulse(order: usize) -> Self {
        Self::new((0..order).map(zonal_norm).collect())
    }

    /// The irradiance of a surface that faces the axis, from light with these coefficients.
    ///
    /// ```text
    ///   E = Σ_l A_l z_l K_l
    /// ```
    ///
    /// Order 0 has none: 0.
    #[must_use]
    pub fn facing_irradiance(&self) -> f64 {
        let cosine = Self::clamped_cosine(self.order());
        let bands = cosine.factors().zip(self.coefficients()).enumerate();
        // From +0: the sum of no numbers is -0.
        bands.fold(0.0, |sum, (l, (a, z))| sum + a * z * zonal_norm(l))
    }
}

/// The factor that makes a white surface reflect 1 when it faces a directional light of a given order.
///
/// ```text
///   4π, 4π/3, 16π/17, 16π/17, 32π/31, 32π/31, 256π/261, 256π/261, 512π/505, 512π/505 for orders 1 to 10
/// ```
///
/// For order 0 it is infinite.
#[must_use]
pub fn directional_normalization(order: usize) -> f64 {
    if order == 0 {
        return f64::INFINITY;
    }
    PI / Zonal::impulse(order).facing_irradiance()
}

/// The irradiance of a surface that faces a cone of radiance 1: `π sin² a`, from 90° on `π`.
pub(crate) fn cone_irradiance(half_angle: f64) -> f64 {
    PI * half_angle.min(FRAC_PI_2).sin().powi(2)
}

/// The irradiance of a surface that faces a soft cone, `π ∫ f(t) sin 2t dt` up to the horizon.
///
/// ```text
///   a <= π/2:  π s_2(a), see Zonal::soft_cone
///   a >= π/2:  π (1 - 3 (π²/8 - 1/2)/a² + 2 (π³/16 - 3π/8)/a³)
/// ```
pub(crate) fn soft_cone_irradiance(a: f64) -> f64 {
    if a <= FRAC_PI_2 {
        return PI * ease_sine(2, a);
    }
    let (square, cube) = (PI * PI / 8.0 - 0.5, PI.powi(3) / 16.0 - 3.0 * PI / 8.0);
    PI * (1.0 - 3.0 * square / (a * a) + 2.0 * cube / (a * a * a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::quadrature::gauss_legendre;
    use lobe_testkit::golden;

    #[test]
    fn directional_lights_have_their_golden_factors() {
        for (order, value) in golden("/directional_norm").as_object().unwrap() {
            let (order, value) = (order.parse().unwrap(), value.as_f64().unwrap());
            let found = directional_normalization(order);
            assert!((found / value - 1.0).abs() < 1e-14, "order {order}: {found} against {value}");
        }
        let fractions =
            [(4, 1), (4, 3), (16, 17), (16, 17), (32, 31), (32, 31), (256, 261), (256, 261), (512, 505), (512, 505)];
        for (k, (p, q)) in fractions.into_iter().enumerate() {
            let (found, expected) = (directional_normalization(k + 1), PI * f64::from(p) / f64::from(q));
            assert!((found / expected - 1.0).abs() < 1e-14, "order {}: {found} against {p}π/{q}", k + 1);
        }
    }

    #[test]
    fn no_bands_receive_nothing_and_no_factor_makes_up_for_it() {
        let none = Zonal::impulse(0).facing_irradiance();
        assert!(none == 0.0 && none.is_sign_positive(), "{none} from order 0");
        assert_eq!(directional_normalization(0), f64::INFINITY, "the factor of order 0");
    }

    #[test]
    fn a_surface_turned_away_receives_the_known_leak() {
        let leaks =
            [(2, -1.0 / 3.0), (3, 1.0 / 17.0), (4, 1.0 / 17.0), (5, -1.0 / 31.0), (7, 5.0 / 261.0), (9, -7.0 / 505.0)];
        for (order, leak) in leaks {
            let reflected = &Zonal::clamped_cosine(order) * (directional_normalization(order) / PI);
            assert!((reflected.eval(1.0) - 1.0).abs() < 1e-14, "order {order}, facing: {}", reflected.eval(1.0));
            assert!((reflected.eval(-1.0) - leak).abs() < 1e-14, "order {order}, away: {}", reflected.eval(-1.0));
        }
    }

    #[test]
    fn exact_irradiances_equal_quadrature() {
        for degrees in [0.01, 1.0, 30.0, 89.0, 91.0, 140.0, 180.0_f64] {
            let a = degrees.to_radians();
            let end = a.min(FRAC_PI_2);
            let integrate = |f: &dyn Fn(f64) -> f64| -> f64 {
                let term = |&(x, w): &(f64, f64)| {
                    let t = 0.5 * end * (1.0 + x);
                    0.5 * end * w * PI * (2.0 * t).sin() * f(t)
                };
                gauss_legendre(40).iter().map(term).sum()
            };
            let (hard, soft) =
                (integrate(&|_| 1.0), integrate(&|t| 1.0 - 3.0 * (t / a).powi(2) + 2.0 * (t / a).powi(3)));
            assert!((cone_irradiance(a) / hard - 1.0).abs() < 1e-13, "{degrees}: {} {hard}", cone_irradiance(a));
            assert!(
                (soft_cone_irradiance(a) / soft - 1.0).abs() < 1e-13,
                "{degrees}: {} {soft}",
                soft_cone_irradiance(a)
            );
        }
    }
}
