//! Analytic lights by name, as a program or a command line describes them.

use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::error::ShError;
use crate::expansion::{Expansion as _, FixedOrder, ShVec, Zonal};
use crate::light::normalization::Normalization;
use crate::light::normalization::{cone_irradiance, soft_cone_irradiance};
use crate::light::spherical_polygon::SphericalPolygon;
use crate::scalar::{Coefficient, Rgb};
use crate::sphere::Dir;

/// An analytic light, to be turned into an expansion of any order by [`Light::project`].
///
/// ```
/// use lobe_sh::light::Normalization;
/// use lobe_sh::{Dir, Expansion as _, Light, Rgb, Zonal};
///
/// let sun = Light::Directional { dir: Dir::X, color: Rgb::new(1.0, 0.9, 0.7) };
/// let light = sun.project(3, Normalization::Projected)?;
/// // A white diffuse surface that faces it leaves E/π: the color.
/// let irradiance = light.convolved(&Zonal::clamped_cosine(3)).eval(Dir::X);
/// assert!((irradiance.g / std::f64::consts::PI - 0.9).abs() < 1e-14);
/// # Ok::<(), lobe_sh::ShError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "kind", rename_all = "kebab-case")
)]
#[non_exhaustive]
pub enum Light {
    /// The same radiance from everywhere. A white surface reflects the color, whatever the normalization.
    Ambient {
        /// Radiance.
        color: Rgb<f64>,
    },
    /// From one direction.
    Directional {
        /// Towards the light.
        dir: Dir,
        /// See [`Normalization`].
        color: Rgb<f64>,
    },
    /// A disc of constant radiance, or a sphere ([`Light::sphere`]).
    Cone {
        /// Towards its center.
        dir: Dir,
        /// In radians, in `(0, π]`.
        half_angle: f64,
        /// See [`Normalization`].
        color: Rgb<f64>,
    },
    /// A disc that fades towards its edge; see [`Zonal::soft_cone`].
    SoftCone {
        /// Towards its center.
        dir: Dir,
        /// In radians, in `(0, π]`.
        half_angle: f64,
        /// See [`Normalization`]; the radiance is that of the center.
        color: Rgb<f64>,
    },
    /// A plane polygon, or any contour; see [`SphericalPolygon`]. The surface that faces it has its normal along the
    /// vector irradiance.
    Polygon {
        /// As seen from the receiver.
        polygon: SphericalPolygon,
        /// See [`Normalization`].
        color: Rgb<f64>,
    },
    /// Radiance that is linear in the height `t = s·up`, from `ground` at the nadir to `sky` at the zenith.
    ///
    /// ```text
    ///   L = c ((1+t)/2 sky + (1-t)/2 ground)
    ///   c = 1 (Normalization::None),    c = 6 max/(5 max + min) of sky and ground, channel by channel (the others)
    /// ```
    ///
    /// With that `c` a surface facing the brighter end reflects exactly its color: `c` is 6/5 for a black ground, 1 for
    /// equal ends. (D3DX takes 3/2, which reflects 5/4 of it.) From order 2 on the expansion is exact; at order 1
    /// `Projected` has `c = 2 max/(max + min)`.
    Hemisphere {
        /// The zenith.
        up: Dir,
        /// Radiance at the zenith, not negative.
        sky: Rgb<f64>,
        /// Radiance at the nadir, not negative.
        ground: Rgb<f64>,
    },
    /// Three colors, linear in the height `t = s·up` from the horizon up and from the horizon down. All three are
    /// radiance, whatever the normalization.
    ///
    /// ```text
    ///   L = horizon + (zenith - horizon) max(t, 0) + (ground - horizon) max(-t, 0)
    /// ```
    Gradient {
        /// The zenith.
        up: Dir,
        /// Radiance at the zenith.
        zenith: Rgb<f64>,
        /// Radiance at the horizon.
        horizon: Rgb<f64>,
        /// Radiance at the nadir.
        ground: Rgb<f64>,
    },
}

impl Light {
    /// A sphere of constant radiance: the cone of half angle `asin(radius/distance)`, the same for every band.
    ///
    /// # Errors
    /// [`ShError::Options`] unless `0 < radius < distance`, both finite: inside the sphere there is no cone.
    pub fn sphere(dir: Dir, distance: f64, radius: f64, color: Rgb<f64>) -> Result<Self, ShError> {
        if !(radius > 0.0 && radius < distance && distance.is_finite()) {
            return Err(ShError::Options(format!(
                "a spherical light needs 0 < radius < distance, found radius {radius} at distance {distance}"
            )));
        }
        Ok(Self::Cone { dir, half_angle: (radius / distance).asin(), color })
    }

    /// The expansion of the light.
    ///
    /// # Errors
    /// [`ShError::Options`] for a half angle outside `(0, π]`, a color that is not finite, a hemisphere of negative
    /// color, and a light too small to be normalized (a polygon without area; a cone below some 1e-150 rad). Order 0
    /// is empty.
    pub fn project(&self, order: usize, normalization: Normalization) -> Result<ShVec<Rgb<f64>>, ShError> {
        self.check()?;
        if order == 0 {
            return Ok(ShVec::zero(0));
        }
        let shaped = |shape: Zonal, dir: Dir, exact: f64, color: Rgb<f64>| {
            let factor = factor(normalization, || shape.facing_irradiance(), || exact)?;
            Ok(shape.towards(dir, color.scale(factor)))
        };
        match *self {
            Self::Ambient { color } => Ok(ShVec::constant(order, color)),
            Self::Directional { dir, color } => shaped(Zonal::impulse(order), dir, 1.0, color),
            Self::Cone { dir, half_angle, color } => {
                shaped(Zonal::cone(order, half_angle), dir, cone_irradiance(half_angle), color)
            }
            Self::SoftCone { dir, half_angle, color } => {
                shaped(Zonal::soft_cone(order, half_angle), dir, soft_cone_irradiance(half_angle), color)
            }
            Self::Polygon { ref polygon, color } => {
                let factor = polygon_factor(polygon, order, normalization)?;
                Ok(polygon.project(order).map(|f| color.scale(f * factor)))
            }
            Self::Hemisphere { up, sky, ground } => Ok(hemisphere(order, up, sky, ground, normalization)),
            Self::Gradient { up, zenith, horizon, ground } => {
                let mut light = ShVec::constant(order, horizon);
                let slope = Zonal::clamped_cosine(order);
                light += &slope.towards(up, zenith - horizon);
                light += &slope.towards(-up, ground - horizon);
                Ok(light)
            }
        }
    }

    /// [`Light::project`] to the order of the type that is asked for, of colors in `f32` or `f64`.
    ///
    /// ```
    /// use lobe_sh::light::Normalization;
    /// use lobe_sh::{Light, Rgb, ShL2};
    ///
    /// let sky = Light::Ambient { color: Rgb::new(0.2, 0.3, 0.5) };
    /// let light: ShL2<Rgb<f32>> = sky.project_as(Normalization::Projected)?;
    /// # assert!((light[0].g - 0.3 * (4.0 * std::f32::consts::PI).sqrt()).abs() < 1e-6, "{light:?}");
    /// # Ok::<(), lobe_sh::ShError>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Light::project`].
    pub fn project_as<E>(&self, normalization: Normalization) -> Result<E, ShError>
    where
        E: FixedOrder<Value: Coefficient<Wide = Rgb<f64>>>,
    {
        Ok(self.project(E::ORDER, normalization)?.map(E::Value::narrow).to_fixed())
    }

    fn check(&self) -> Result<(), ShError> {
        let colors: &[Rgb<f64>] = match self {
            Self::Ambient { color }
            | Self::Directional { color, .. }
            | Self::Cone { color, .. }
            | Self::SoftCone { color, .. }
            | Self::Polygon { color, .. } => &[*color],
            Self::Hemisphere { sky, ground, .. } => &[*sky, *ground],
            Self::Gradient { zenith, horizon, ground, .. } => &[*zenith, *horizon, *ground],
        };
        for color in colors {
            let [r, g, b] = color.to_array();
            if !(r.is_finite() && g.is_finite() && b.is_finite()) {
                return Err(ShError::Options(format!("a light needs a finite color, found {r},{g},{b}")));
            }
            if matches!(self, Self::Hemisphere { .. }) && r.min(g).min(b) < 0.0 {
                return Err(ShError::Options(format!(
                    "a hemisphere needs colors that are not negative, found {r},{g},{b}"
                )));
            }
        }
        match self {
            Self::Cone { half_angle, .. } | Self::SoftCone { half_angle, .. }
                if !(*half_angle > 0.0 && *half_angle <= PI) =>
            {
                let degrees = half_angle.to_degrees();
                Err(ShError::Options(format!("a half angle lies above 0 and up to 180 degrees, found {degrees}")))
            }
            _ => Ok(()),
        }
    }
}

/// The factor that normalizes a light; `projected` and `exact` are irradiances of the facing surface.
fn factor(
    normalization: Normalization,
    projected: impl FnOnce() -> f64,
    exact: impl FnOnce() -> f64,
) -> Result<f64, ShError> {
    let irradiance = match normalization {
        Normalization::None => return Ok(1.0),
        Normalization::Projected => projected(),
        Normalization::Analytic => exact(),
    };
    let factor = PI / irradiance;
    if irradiance > 0.0 && factor.is_finite() {
        Ok(factor)
    } else {
        Err(ShError::Options(format!(
            "a facing surface receives {irradiance:e} from this light: too little to be normalized; use none"
        )))
    }
}

fn polygon_factor(polygon: &SphericalPolygon, order: usize, normalization: Normalization) -> Result<f64, ShError> {
    let vector = polygon.vector_irradiance();
    let facing = Dir::new(vector).unwrap_or(Dir::Z);
    let projected = || Zonal::clamped_cosine(order).towards(facing, 1.0_f64);
    // The irradiance is the product of the light with the cosine towards the normal.
    let projected = || projected().dot(&polygon.project(order));
    let exact = || {
        let above = polygon.above(facing).vector_irradiance();
        above.iter().zip(facing.to_array()).map(|(a, n)| a * n).sum()
    };
    factor(normalization, projected, exact)
}

fn hemisphere(order: usize, up: Dir, sky: Rgb<f64>, ground: Rgb<f64>, normalization: Normalization) -> ShVec<Rgb<f64>> {
    // A surface that faces one end receives (1 + slope)/2 of its color from that end and (1 - slope)/2 from the other.
    let slope = match normalization {
        Normalization::Projected if order == 1 => 0.0,
        _ => 2.0 / 3.0,
    };
    let factor = |sky: f64, ground: f64| {
        let (brighter, darker) = (sky.max(ground), sky.min(ground));
        let received = 0.5 * ((1.0 + slope) * brighter + (1.0 - slope) * darker);
        if normalization == Normalization::None || received == 0.0 { 1.0 } else { brighter / received }
    };
    let scale = Rgb::from_channels(|c| factor(sky.channel(c), ground.channel(c)));
    let mut light = ShVec::constant(order, (sky + ground).scale(0.5) * scale);
    // t = s·up has the one coefficient 4π/3 K_1 in band 1.
    let height = Zonal::from_convolution_factors([0.0, 4.0 * PI / 3.0]).resized(order);
    light += &height.towards(up, (sky - ground).scale(0.5) * scale);
    light
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::project;
    use crate::sphere::quadrature::SphereQuadrature;

    const WHITE: Rgb<f64> = Rgb::new(1.0, 1.0, 1.0);

    fn reflected(light: &ShVec<Rgb<f64>>, normal: Dir) -> Rgb<f64> {
        light.convolved(&Zonal::clamped_cosine(light.order())).eval(normal).scale(1.0 / PI)
    }

    fn directions() -> impl Iterator<Item = Dir> {
        lobe_testkit::directions().into_iter().step_by(7).map(Dir::from_unit)
    }

    #[test]
    fn a_facing_white_surface_leaves_the_color() {
        let color = Rgb::new(0.5, 2.0, 0.0);
        for dir in directions() {
            let (half_angle, triangle) = (0.4, triangle_around(dir));
            for light in [
                Light::Ambient { color },
                Light::Directional { dir, color },
                Light::Cone { dir, half_angle, color },
                Light::SoftCone { dir, half_angle, color },
                Light::sphere(dir, 3.0, 1.0, color).unwrap(),
                Light::Hemisphere { up: dir, sky: color, ground: color.scale(0.3) },
                Light::Polygon { polygon: triangle, color },
            ] {
                for order in 1..=10 {
                    let leaves = reflected(&light.project(order, Normalization::Projected).unwrap(), dir);
                    let error = (leaves - color).to_array().iter().fold(0.0_f64, |m, c| m.max(c.abs()));
                    assert!(error < 1e-12, "{light:?}, order {order}: {leaves:?}");
                }
            }
        }
    }

    /// A triangle whose vector irradiance is along `dir`: regular, in a plane across it.
    fn triangle_around(dir: Dir) -> SphericalPolygon {
        let n = dir.to_array();
        let helper = if n[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let u = Dir::new(cross(helper, n)).unwrap().to_array();
        let v = cross(n, u);
        let corner = |k: u32| {
            let (sin, cos) = (2.0 * PI * f64::from(k) / 3.0).sin_cos();
            [0, 1, 2].map(|i| 2.0 * n[i] + cos * u[i] + sin * v[i])
        };
        SphericalPolygon::new(vec![corner(0), corner(1), corner(2)]).unwrap()
    }

    #[test]
    fn the_analytic_factor_is_the_limit_of_the_projected_one() {
        let dir = Dir::from_angles(1.0, 2.0);
        for light in [
            Light::Cone { dir, half_angle: 0.4, color: WHITE },
            Light::Cone { dir, half_angle: 2.0, color: WHITE },
            Light::SoftCone { dir, half_angle: 0.9, color: WHITE },
            Light::SoftCone { dir, half_angle: 2.5, color: WHITE },
            Light::Directional { dir, color: WHITE },
            Light::Polygon { polygon: triangle_around(dir), color: WHITE },
        ] {
            let [projected, analytic] = [Normalization::Projected, Normalization::Analytic]
                .map(|normalization| light.project(60, normalization).unwrap()[0].r);
            assert!((projected / analytic - 1.0).abs() < 1e-3, "{light:?}: {projected} against {analytic}");
        }
    }

    #[test]
    fn a_sphere_is_the_cone_it_subtends() {
        let sphere = Light::sphere(Dir::Y, 2.0, 1.0, WHITE).unwrap().project(10, Normalization::None).unwrap();
        let cone = Light::Cone { dir: Dir::Y, half_angle: PI / 6.0, color: WHITE };
        let cone = cone.project(10, Normalization::None).unwrap();
        for (i, (a, b)) in sphere.coefficients().iter().zip(cone.coefficients()).enumerate() {
            assert!((a.r - b.r).abs() < 1e-15, "i {i}: {a:?} against {b:?}");
        }
    }

    #[test]
    fn a_bare_directional_light_is_the_basis_towards_it() {
        let dir = Dir::from_angles(2.0, -1.0);
        let bare = Light::Directional { dir, color: WHITE }.project(5, Normalization::None).unwrap();
        for (i, (a, y)) in bare.coefficients().iter().zip(crate::eval_basis(dir, 5)).enumerate() {
            assert!((a.g - y).abs() < 1e-15, "i {i}: {a:?} against {y}");
        }
    }

    #[test]
    fn skies_equal_their_projections() {
        let (sky, horizon, ground) = (Rgb::new(0.2, 0.5, 1.0), Rgb::new(1.0, 0.8, 0.6), Rgb::new(0.1, 0.0, 0.3));
        for up in directions() {
            let hemisphere = Light::Hemisphere { up, sky, ground }.project(4, Normalization::None).unwrap();
            let expected = project(4, 1, |s| (sky.scale(1.0 + s.dot(up)) + ground.scale(1.0 - s.dot(up))).scale(0.5));
            let gradient = Light::Gradient { up, zenith: sky, horizon, ground };
            let gradient = gradient.project(9, Normalization::Projected).unwrap();
            for i in 0..16 {
                let error = (hemisphere[i] - expected[i]).luminance().abs();
                assert!(error < 1e-14, "hemisphere {up:?}, i {i}: {:?} against {:?}", hemisphere[i], expected[i]);
            }
            // The fold at the horizon is integrated exactly about +z, where the rule may be broken there.
            let about_z = Light::Gradient { up: Dir::Z, zenith: sky, horizon, ground };
            let about_z = about_z.project(9, Normalization::None).unwrap();
            for l in 0..9 {
                let exact = |a: f64, h: f64, b: f64| {
                    let value = |t: f64| h + (a - h) * t.max(0.0) + (b - h) * (-t).max(0.0);
                    Zonal::project(9, &[0.0], 8, value)[l]
                };
                let (found, expected) = (about_z[l * (l + 1)].r, exact(sky.r, horizon.r, ground.r));
                assert!((found - expected).abs() < 1e-14, "gradient, band {l}: {found} against {expected}");
            }
            let energy = |f: &ShVec<Rgb<f64>>| f.dot(f).b;
            let (a, b) = (energy(&gradient), energy(&about_z));
            assert!((a - b).abs() < 1e-12, "the gradient only turns with its zenith: {a} against {b}");
        }
    }

    #[test]
    fn the_hemisphere_has_six_fifths_and_stays_positive() {
        let light = Light::Hemisphere { up: Dir::Z, sky: WHITE, ground: Rgb::default() };
        let raw = light.project(2, Normalization::None).unwrap();
        assert!((reflected(&raw, Dir::Z).r - 5.0 / 6.0).abs() < 1e-14, "{:?}", reflected(&raw, Dir::Z));
        let normalized = light.project(2, Normalization::Projected).unwrap();
        assert!((normalized[0].r / raw[0].r - 1.2).abs() < 1e-14, "{:?}", normalized[0]);
        let upside_down = Light::Hemisphere { up: Dir::Z, sky: Rgb::default(), ground: WHITE };
        let upside_down = upside_down.project(3, Normalization::Analytic).unwrap();
        assert!((reflected(&upside_down, -Dir::Z).r - 1.0).abs() < 1e-14, "a bright ground");
        for (s, _) in SphereQuadrature::of_degree(6).points() {
            assert!(normalized.eval(s).r > -1e-14, "towards {s:?}: {:?}", normalized.eval(s));
        }
    }

    #[test]
    fn bad_lights_are_refused_in_one_line() {
        let nan = Rgb::new(f64::NAN, 0.0, 0.0);
        let negative = Rgb::new(-1.0, 0.0, 0.0);
        let cone = |half_angle: f64| Light::Cone { dir: Dir::X, half_angle, color: WHITE };
        for (light, what) in [
            (cone(0.0), "half angle"),
            (cone(-1.0), "half angle"),
            (cone(3.2), "half angle"),
            (cone(f64::NAN), "half angle"),
            (cone(1e-200), "too little"),
            (Light::SoftCone { dir: Dir::X, half_angle: 4.0, color: WHITE }, "half angle"),
            (Light::Ambient { color: nan }, "finite"),
            (Light::Hemisphere { up: Dir::Z, sky: WHITE, ground: negative }, "not negative"),
        ] {
            let error = light.project(3, Normalization::Projected).unwrap_err().to_string();
            assert!(error.contains(what) && !error.contains('\n'), "{light:?}: {error}");
        }
        for (distance, radius) in
            [(1.0, 1.0), (1.0, 2.0), (1.0, 0.0), (1.0, -1.0), (f64::NAN, 1.0), (f64::INFINITY, 1.0)]
        {
            let error = Light::sphere(Dir::X, distance, radius, WHITE).unwrap_err().to_string();
            assert!(error.contains("radius < distance"), "{distance}, {radius}: {error}");
        }
        let flat = SphericalPolygon::new(vec![[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 2.0, 0.0]]).unwrap();
        let flat = Light::Polygon { polygon: flat, color: WHITE };
        let error = flat.project(3, Normalization::Analytic).unwrap_err().to_string();
        assert!(error.contains("too little"), "a polygon without area: {error}");
        assert_eq!(flat.project(0, Normalization::Projected).unwrap().order(), 0, "order 0");
    }
}
