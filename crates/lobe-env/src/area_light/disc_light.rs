//! Disc light: irradiance in closed form.

use std::f64::consts::PI;

use lobe_sh::Dir;

use crate::area_light::area_light::from_vec3;
use lobe_sh::sphere::vector::{Vec3, add_scaled, cross, dot, length, sub, tangents_along_axis};

use crate::area_light::area_light::{AreaLight, PointLight};
use crate::area_light::vector_irradiance::VectorIrradiance;

/// A disc that emits radiance 1 to the side its normal points to.
///
/// With the receiver at height `H > 0` in front of the disc's plane and at the distance `a` from its axis; `w` is the
/// direction from the receiver to the plane, `u` that from the receiver to the axis:
///
/// ```text
///   e = π R² / (S (S + A)) (2aH u + (S - p) w)
///
///   A = a² + H² + R²        S = √(A² - 4a²R²)        p = a² - R² - H²
/// ```
///
/// `S - p` is computed as `4a²H²/(S + p)` where `p > 0`. On the axis `e = π R²/(H² + R²) w`. Where the horizon of the
/// receiver cuts the disc, the visible part of its rim and the angle of the cut along the horizon are integrated in
/// closed form (the block above the code). The two then cancel from `R/d` to `(R/d)²` and lose the digits of `d/R`;
/// test `a_disc_equals_quadrature_for_every_normal` bounds the absolute error by 1e-11, most of it the quadrature's.
///
/// Degenerate cases: a receiver behind the disc or in its plane (edge-on) gets 0; radius 0 gives 0; on the disc itself
/// it is in its plane, so 0, although the limit from the front is `π` for a normal that faces it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DiscLight {
    /// The center.
    pub center: [f64; 3],
    /// The side that emits.
    pub normal: Dir,
    /// The radius, not negative.
    pub radius: f64,
}

// In the frame (u, v, w) of the receiver the rim is r(φ) = (a + R cos φ) u + R sin φ v + H w. By Stokes
//
//     ∫ s ds = ½ ∮ (r × r')/|r|² dφ        |r|² = A + B cos φ        B = 2aR
//     r × r' = -HR cos φ u - HR sin φ v + (R² + aR cos φ) w
//
// With b = B/(A + S), |b| < 1 and A + B cos φ = ½(A + S) |1 + b e^{iφ}|², the integrals from φ₁ to φ₂ are
//
//     ∫ dφ/|r|²       = (Δφ - 2Δδ)/S                              δ(φ) = arg(1 + b e^{iφ}) = atan2(b sin φ, 1 + b cos φ)
//     ∫ cos φ dφ/|r|² = (2A/(A + S) Δ(δ/b) - b Δφ)/S
//     ∫ sin φ dφ/|r|² = -Δ(ln(1 + b(2 cos φ + b))/b)/(A + S)
//
// none of which divides by a small number: δ/b and ln(..)/b tend to sin φ and 2 cos φ. Over the whole rim Δφ = 2π and
// the others vanish, which leaves the vector above.

/// The disc in the frame of the receiver.
struct LocalDisc {
    u: Vec3,
    v: Vec3,
    w: Vec3,
    a: f64,
    height: f64,
    radius: f64,
    big_a: f64,
    s: f64,
}

impl LocalDisc {
    /// `None` from behind or edge-on.
    fn new(light: &DiscLight, point: Vec3) -> Option<Self> {
        debug_assert!(light.radius >= 0.0, "a radius of {}", light.radius);
        let w = (-light.normal).to_array();
        let to_center = sub(light.center, point);
        let height = dot(to_center, w);
        if height <= 0.0 || light.radius == 0.0 {
            return None;
        }
        let aside = add_scaled(to_center, w, -height);
        let a = length(aside);
        let u = if a > 0.0 { aside.map(|c| c / a) } else { tangents_along_axis(w)[0] };
        let radius = light.radius;
        let s = (a * a + height * height - radius * radius).hypot(2.0 * height * radius);
        Some(Self { u, v: cross(w, u), w, a, height, radius, big_a: a * a + height * height + radius * radius, s })
    }

    fn vector(&self) -> Vec3 {
        let (a, height, radius) = (self.a, self.height, self.radius);
        let p = a * a - radius * radius - height * height;
        let along_w = if p > 0.0 { 4.0 * (a * height).powi(2) / (self.s + p) } else { self.s - p };
        let scale = PI * radius * radius / (self.s * (self.s + self.big_a));
        let e = self.u.map(|c| c * scale * 2.0 * a * height);
        add_scaled(e, self.w, scale * along_w)
    }

    /// The irradiance of the part above the horizon of `n`.
    fn irradiance(&self, n: Vec3) -> f64 {
        let (n_u, n_v, n_w) = (dot(n, self.u), dot(n, self.v), dot(n, self.w));
        // n·r = center + swing cos(φ - ψ)
        let center = n_u * self.a + n_w * self.height;
        let swing = self.radius * n_u.hypot(n_v);
        if center >= swing {
            return dot(n, self.vector()).max(0.0);
        }
        if center <= -swing {
            return 0.0;
        }
        let psi = n_v.atan2(n_u);
        let half = ((swing - center) * (swing + center)).sqrt().atan2(-center);
        let ends = [psi - half, psi + half];
        let [first, last] = ends.map(|phi| self.rim(phi));
        let horizon = length(cross(first, sub(last, first))).atan2(dot(first, last));
        (0.5 * (self.arc([n_u, n_v, n_w], ends) + horizon)).max(0.0)
    }

    fn rim(&self, phi: f64) -> Vec3 {
        let (sin, cos) = phi.sin_cos();
        [self.a + self.radius * cos, self.radius * sin, self.height]
    }

    /// `∫ n·(r × r')/|r|² dφ` between two azimuths of the rim; `n` in the frame `(u, v, w)`.
    fn arc(&self, n: Vec3, ends: [f64; 2]) -> f64 {
        let (a, height, radius) = (self.a, self.height, self.radius);
        let sum = self.big_a + self.s;
        let b = 2.0 * a * radius / sum;
        let [first, last] = ends.map(|phi| {
            let (sin, cos) = phi.sin_cos();
            let delta = (b * sin).atan2(1.0 + b * cos);
            if b < f64::MIN_POSITIVE {
                return [delta, sin, 2.0 * cos];
            }
            [delta, delta / b, (b * (2.0 * cos + b)).ln_1p() / b]
        });
        let [d_delta, d_ratio, d_log] = sub(last, first);
        let d_phi = ends[1] - ends[0];
        let one = (d_phi - 2.0 * d_delta) / self.s;
        let cos = (2.0 * self.big_a / sum * d_ratio - b * d_phi) / self.s;
        let sin = -d_log / sum;
        let [n_u, n_v, n_w] = n;
        radius * (radius * n_w * one + (a * n_w - height * n_u) * cos - height * n_v * sin)
    }
}

impl AreaLight for DiscLight {
    fn irradiance(&self, point: [f64; 3], normal: Dir) -> f64 {
        LocalDisc::new(self, point).map_or(0.0, |disc| disc.irradiance(normal.to_array()))
    }

    fn vector_irradiance(&self, point: [f64; 3]) -> VectorIrradiance<f64> {
        LocalDisc::new(self, point).map_or_else(VectorIrradiance::default, |disc| from_vec3(disc.vector()))
    }

    fn as_point(&self) -> PointLight {
        PointLight { position: self.center, normal: Some(self.normal), area: PI * self.radius * self.radius }
    }
}
