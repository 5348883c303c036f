//! Area lights, and their approximations by point lights and parallel beams.

use lobe_sh::Dir;

use crate::area_light::vector_irradiance::VectorIrradiance;
use lobe_sh::sphere::vector::{Vec3, dot, length, sub};

/// A Lambertian light: a surface that emits radiance 1 to one side.
///
/// All quantities are proportional to the radiance. Positions are in any unit of length, the same for the light and the
/// receiver. The back of a flat light is black, and so is the inside of a sphere; a two-sided light is two lights.
/// There is no occlusion between light and receiver.
///
/// ```text
///   E(p, n) = ∫_Ω max(n·s, 0) ds      e(p) = ∫_Ω s ds      Ω = the directions in which p sees the luminous side
/// ```
pub trait AreaLight {
    /// The exact irradiance `E(p, n)` on a surface at `point` that faces `normal`; the light is clipped at its horizon.
    fn irradiance(&self, point: [f64; 3], normal: Dir) -> f64;

    /// The exact vector irradiance `e(p)`: `n·e = E(p, n) - E(p, -n)`.
    fn vector_irradiance(&self, point: [f64; 3]) -> VectorIrradiance<f64>;

    /// The point source that the light tends to with distance.
    fn as_point(&self) -> PointLight;
}

/// A point source: the limit of a small light.
///
/// ```text
///   E = I(-s) max(n·s, 0) / d²       s = the direction to the light      d = the distance
///   I(ω) = area max(normal·ω, 0)     or the same in every direction, area, without a normal
/// ```
///
/// Its error, measured by [`compare_approximations`] (tests `far_lights_are_points_within_their_squared_size`):
///
/// | light | receiver | relative error of the point |
/// |---|---|---|
/// | sphere | sees it whole | 0 at any distance |
/// | disc, radius R | on its axis, facing it | `(R/d)²` too bright |
/// | square, side 2a | on its axis, facing it | `(4/3) (a/d)²` too bright, less `O(a/d)⁴` |
/// | any | the horizon cuts the light | all of it where the center is below |
///
/// So at five times its diameter a light is a point to 1 %.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PointLight {
    /// The position.
    pub position: [f64; 3],
    /// The normal of its emission by the cosine law; `None` for isotropic emission.
    pub normal: Option<Dir>,
    /// The area seen from the direction of the normal: the intensity in that direction for radiance 1.
    pub area: f64,
}

impl PointLight {
    /// The irradiance on a surface at `point` that faces `normal`. Infinite or NaN at the light itself.
    #[must_use]
    pub fn irradiance(&self, point: [f64; 3], normal: Dir) -> f64 {
        let to_light = sub(self.position, point);
        let d = length(to_light);
        let intensity = self.normal.map_or(self.area, |n| self.area * (-dot(n.to_array(), to_light) / d).max(0.0));
        intensity * (dot(normal.to_array(), to_light) / d).max(0.0) / (d * d)
    }
}

/// A parallel beam: the limit of a light that is far away from everything it shines on.
///
/// Fitted to a light at one place, it is exact there for every normal whose horizon does not cut the light. At a place
/// further from the light by `δ` it is too bright by `2δ/d + (δ/d)²` (for a light as small as a point), and at a place
/// to the side its direction is off by `atan(δ/d)`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ParallelBeam {
    /// The direction that the light comes from.
    pub direction: Dir,
    /// The irradiance on a surface that faces it.
    pub irradiance: f64,
}

impl ParallelBeam {
    /// The beam with the vector irradiance of `light` at `point`; `None` where no light arrives.
    #[must_use]
    pub fn of(light: &impl AreaLight, point: [f64; 3]) -> Option<Self> {
        let e = light.vector_irradiance(point);
        e.dir(0).map(|direction| Self { direction, irradiance: e.magnitude(0) })
    }

    /// The irradiance on a surface that faces `normal`.
    #[must_use]
    pub fn irradiance(&self, normal: Dir) -> f64 {
        self.irradiance * normal.dot(self.direction).max(0.0)
    }
}

/// The irradiance of one light by the closed form and by two approximations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approximations {
    /// In closed form.
    pub exact: f64,
    /// As a point light at its center.
    pub point: f64,
    /// As a parallel beam, fitted at a place of reference.
    pub directional: f64,
}

impl Approximations {
    /// `point / exact - 1`; infinite or NaN where no light arrives.
    #[must_use]
    pub fn point_error(&self) -> f64 {
        self.point / self.exact - 1.0
    }

    /// `directional / exact - 1`; infinite or NaN where no light arrives.
    #[must_use]
    pub fn directional_error(&self) -> f64 {
        self.directional / self.exact - 1.0
    }
}

/// Compares the irradiance of `light` on a surface at `point` that faces `normal` with that of its point light, and of
/// the beam fitted at `reference`.
///
/// ```
/// use lobe_env::{DiscLight, compare_approximations};
/// use lobe_sh::Dir;
///
/// // A disc of radius 1 overhead, ten radii away: as a point it is 1 % too bright.
/// let light = DiscLight { center: [0.0, 0.0, 10.0], normal: -Dir::Z, radius: 1.0 };
/// let here = [0.0; 3];
/// let found = compare_approximations(&light, here, here, Dir::Z);
/// assert!((found.point_error() - 0.01).abs() < 1e-14);
/// assert!(found.directional_error().abs() < 1e-14);
/// ```
#[must_use]
pub fn compare_approximations(
    light: &impl AreaLight,
    reference: [f64; 3],
    point: [f64; 3],
    normal: Dir,
) -> Approximations {
    Approximations {
        exact: light.irradiance(point, normal),
        point: light.as_point().irradiance(point, normal),
        directional: ParallelBeam::of(light, reference).map_or(0.0, |beam| beam.irradiance(normal)),
    }
}

/// The vector `length · direction` of a light's vector irradiance.
pub(crate) fn from_vec3(e: Vec3) -> VectorIrradiance<f64> {
    VectorIrradiance::new(e[0], e[1], e[2])
}
