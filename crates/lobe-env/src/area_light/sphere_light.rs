//! Sphere light: irradiance in closed form.

use std::f64::consts::PI;

use lobe_sh::Dir;

use crate::area_light::area_light::from_vec3;
use crate::area_light::area_light::{AreaLight, PointLight};
use crate::area_light::vector_irradiance::VectorIrradiance;
use lobe_sh::sphere::vector::{dot, length, sub};

/// How far inside the sphere a point of its surface may be found, relative to the largest coordinate of either: it was
/// rounded, and so are its differences from the center and their length.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A sphere that emits radiance 1 from its whole outside.
///
/// With `σ` its angular radius, `sin σ = radius/d`, and `θ` the angle between the normal and the direction `c` of the
/// center:
///
/// ```text
///   e = π sin²σ c
///   E = π sin²σ cos θ                                                           θ + σ <= π/2: seen whole
///   E = sin²σ cos θ φ₀ - sin σ cos σ sin θ sin φ₀ + atan2(sin σ sin θ sin φ₀, cos σ)
///                                               cos φ₀ = -cot σ cot θ           |θ - π/2| < σ: cut by the horizon
///   E = 0                                                                       θ - σ >= π/2: below the horizon
/// ```
///
/// The same as [Snyder 1996] in another arrangement. Where the horizon cuts, the three terms cancel from `σ` to `σ³`:
/// half a sphere is right to `1e-15 + 1e-10 E` (test `a_sphere_at_the_horizon_has_its_known_value`), any part of it to
/// 1e-11 (test `a_sphere_equals_quadrature_for_every_normal`).
///
/// Degenerate cases: on the surface `σ = π/2`, the formulas hold, for points that are on it but for rounding too (test
/// `receivers_on_a_sphere_are_all_lit_alike`); inside, the light is dark, like the back of every [`AreaLight`]; radius 0
/// gives 0.
///
/// [Snyder 1996]: https://www.microsoft.com/en-us/research/publication/area-light-sources-for-real-time-graphics/
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SphereLight {
    /// The center.
    pub center: [f64; 3],
    /// The radius, not negative.
    pub radius: f64,
}

// The cap around c is cut by the horizon of n, where n·s = 0. With u perpendicular to c in the plane of c and n, so
// that n = cos θ c + sin θ u, and v = c × u, the rim of the cap is
//
//     s(φ) = cos σ c + sin σ (cos φ u + sin φ v)          n·s = cos σ cos θ + sin σ sin θ cos φ
//
// and lies above the horizon for |φ| <= φ₀. By Stokes ∫ s ds = ½ ∮ s × ds. Along the rim
//
//     n·(s × s') = sin²σ cos θ - sin σ cos σ sin θ cos φ
//
// which leaves the first two terms. The boundary closes along the horizon, a great circle about n, where
// n·(s × s') = 1: it adds half the angle between its ends. Both ends have components ± sin σ sin φ₀ along v and, along
// the other axis of the horizon plane, sin θ c - cos θ u, the component cos σ / sin θ.

impl AreaLight for SphereLight {
    fn irradiance(&self, point: [f64; 3], normal: Dir) -> f64 {
        let Some((c, sin)) = self.seen_from(point) else { return 0.0 };
        let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
        let cos_theta = normal.dot(c);
        // The height of the lowest and of the highest point of the cap is cos(θ ± σ).
        if cos_theta >= sin {
            return PI * sin * sin * cos_theta;
        }
        if cos_theta <= -sin {
            return 0.0;
        }
        let sin_theta = ((1.0 - cos_theta) * (1.0 + cos_theta)).sqrt();
        let cos_phi = (-cos * cos_theta / (sin * sin_theta)).clamp(-1.0, 1.0);
        // sin²φ₀ = (sin²σ - cos²θ) / (sin²σ sin²θ), whose difference of squares keeps its digits
        let sin_phi = ((sin - cos_theta) * (sin + cos_theta)).max(0.0).sqrt() / (sin * sin_theta);
        let phi = sin_phi.atan2(cos_phi);
        let rim = sin * (sin * cos_theta * phi - cos * sin_theta * sin_phi);
        (rim + (sin * sin_theta * sin_phi).atan2(cos)).max(0.0)
    }

    fn vector_irradiance(&self, point: [f64; 3]) -> VectorIrradiance<f64> {
        self.seen_from(point)
            .map_or_else(VectorIrradiance::default, |(c, sin)| from_vec3(c.to_array().map(|k| PI * sin * sin * k)))
    }

    fn as_point(&self) -> PointLight {
        PointLight { position: self.center, normal: None, area: PI * self.radius * self.radius }
    }
}

impl SphereLight {
    /// The direction of the center and `sin σ`; `None` from inside.
    fn seen_from(&self, point: [f64; 3]) -> Option<(Dir, f64)> {
        let to_center = sub(self.center, point);
        let d = length(to_center);
        debug_assert!(self.radius >= 0.0, "a radius of {}", self.radius);
        let slack = ROUNDING * (length(self.center) + self.radius);
        if d < self.radius - slack || dot(to_center, to_center) == 0.0 {
            return None;
        }
        Some((Dir::new(to_center)?, (self.radius / d).min(1.0)))
    }
}
