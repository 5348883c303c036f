//! Fisheye projections: how far from the middle of a round picture a lens shows a direction.
//!
//! [`FisheyeProjection`] has the formulas. In units of the radius of the circle the four are profiles of [`azimuthal`], cut
//! off at the rim of the circle.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::error::EnvError;
use crate::mapping::azimuthal::{self, Profile, Rect};
use crate::mapping::lat_long::sin_cos_pi;

/// The rounding of an angle that was given in degrees.
const SAME_ANGLE: f64 = 1e-9;

/// How a fisheye lens shows directions: the distance r from the middle of the circle at the angle θ to the axis.
///
/// ```text
///   equidistant     r = f θ               dΩ = sin θ/θ dA/f²           θ <= 180°
///   equisolid       r = 2 f sin(θ/2)      dΩ = dA/f²                   θ <= 180°
///   stereographic   r = 2 f tan(θ/2)      dΩ = cos⁴(θ/2) dA/f²         θ <  180°
///   orthographic    r = f sin θ           dΩ = 1/cos θ dA/f²           θ <=  90°
/// ```
///
/// f is the focal length, which follows from the circle: its radius is r at half of the field of view. An area dA of the
/// picture has the solid angle `dΩ = sin θ/(r dr/dθ) dA`.
///
/// [Kannala and Brandt 2006] lists the four formulas of r; the lens is described in [Miyamoto 1964].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum FisheyeProjection {
    /// `r = f θ`, to 360°.
    #[default]
    Equidistant,
    /// `r = 2 f sin(θ/2)`, to 360°.
    Equisolid,
    /// `r = 2 f tan(θ/2)`, below 360°.
    Stereographic,
    /// `r = f sin θ`, to 180°.
    Orthographic,
}

impl FisheyeProjection {
    /// All projections.
    pub const ALL: [Self; 4] = [Self::Equidistant, Self::Equisolid, Self::Stereographic, Self::Orthographic];

    /// The name on a command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Equidistant => "equidistant",
            Self::Equisolid => "equisolid",
            Self::Stereographic => "stereographic",
            Self::Orthographic => "orthographic",
        }
    }

    /// The projection of a [`name`](Self::name).
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|projection| projection.name() == name)
    }

    /// Refuses a field of view, the full angle across the circle in radians, that no lens of the projection has.
    ///
    /// ```
    /// use lobe_env::FisheyeProjection;
    ///
    /// assert!(FisheyeProjection::Equisolid.check_field_of_view(200_f64.to_radians()).is_ok());
    /// assert!(FisheyeProjection::Orthographic.check_field_of_view(200_f64.to_radians()).is_err());
    /// ```
    ///
    /// # Errors
    /// [`EnvError::Options`] if it is not above 0, above the limit of the projection, or no number.
    pub fn check_field_of_view(self, field_of_view: f64) -> Result<(), EnvError> {
        let (most, limit) = match self {
            Self::Equidistant | Self::Equisolid => (2.0 * PI + SAME_ANGLE, "at most 360°"),
            Self::Stereographic => (2.0 * PI - SAME_ANGLE, "less than 360°"),
            Self::Orthographic => (PI + SAME_ANGLE, "at most 180°"),
        };
        if field_of_view > 0.0 && field_of_view <= most {
            return Ok(());
        }
        let degrees = rounded_degrees(field_of_view);
        let message = format!("the field of view of {self} fisheyes is above 0° and {limit}, and {degrees}° is not");
        Err(EnvError::Options(message))
    }

    /// The profile of the disc, in units of its own.
    fn profile(self) -> Profile {
        match self {
            Self::Equidistant => Profile::Angular,
            Self::Equisolid => Profile::Ball,
            Self::Stereographic => Profile::Paraboloid,
            Self::Orthographic => Profile::Orthographic,
        }
    }
}

impl std::fmt::Display for FisheyeProjection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// An angle in degrees as it was given, without the rounding of its change to radians.
pub(crate) fn rounded_degrees(angle: f64) -> f64 {
    (angle.to_degrees() * 1e6).round() / 1e6
}

/// A lens: a projection whose circle has the radius 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    profile: Profile,
    /// The radius of the circle in units of the profile.
    rim: f64,
    /// Half of the field of view, in radians.
    half: f64,
}

impl Lens {
    /// Of a field of view in radians, which is refused if the projection cannot have it.
    pub(crate) fn new(projection: FisheyeProjection, field_of_view: f64) -> Result<Self, EnvError> {
        projection.check_field_of_view(field_of_view)?;
        let most = if projection == FisheyeProjection::Orthographic { FRAC_PI_2 } else { PI };
        let half = (0.5 * field_of_view).min(most);
        let (sin, cos) = half.sin_cos();
        let profile = projection.profile();
        Ok(Self { profile, rim: profile.radius(cos, sin), half })
    }

    /// `1 - cos θ`, the solid angle per radian within the distance `r` from the middle.
    pub(crate) fn cap(&self, r: f64) -> f64 {
        self.profile.cap(self.rim * r)
    }

    /// The distance from the middle at which directions at the angle `π t` to the axis are shown; `None` beyond the
    /// circle.
    pub(crate) fn radius(&self, t: f64) -> Option<f64> {
        let (sin, cos) = sin_cos_pi(t);
        // At the far pole 0 may have the other sign.
        (PI * t <= self.half).then(|| self.profile.radius(cos, sin.abs()) / self.rim)
    }

    /// The exact solid angle of the part of a pixel in the circle (test
    /// `solid_angles_of_pixels_are_the_density_at_their_middles_times_their_areas`).
    pub(crate) fn solid_angle(&self, pixel: &Rect) -> f64 {
        azimuthal::solid_angle_within(self.profile, self.rim, pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lenses of all projections, narrow, of half of the sphere, and as wide as they are.
    fn lenses() -> impl Iterator<Item = (FisheyeProjection, f64, Lens)> {
        let widest = |projection| match projection {
            FisheyeProjection::Orthographic => 180.0_f64,
            FisheyeProjection::Stereographic => 300.0,
            _ => 360.0,
        };
        let fields = move |projection| [60.0, 180.0, widest(projection)].map(|degrees: f64| (projection, degrees));
        FisheyeProjection::ALL.into_iter().flat_map(fields).map(|(projection, degrees)| {
            let lens = Lens::new(projection, degrees.to_radians()).unwrap();
            (projection, 0.5 * degrees.to_radians(), lens)
        })
    }

    /// r/f at the angle θ, as in the papers.
    fn papers_radius(projection: FisheyeProjection, theta: f64) -> f64 {
        match projection {
            FisheyeProjection::Equidistant => theta,
            FisheyeProjection::Equisolid => 2.0 * (0.5 * theta).sin(),
            FisheyeProjection::Stereographic => 2.0 * (0.5 * theta).tan(),
            FisheyeProjection::Orthographic => theta.sin(),
        }
    }

    /// `f² dΩ/dA` at the angle θ, as documented.
    fn papers_density(projection: FisheyeProjection, theta: f64) -> f64 {
        match projection {
            FisheyeProjection::Equidistant if theta > 0.0 => theta.sin() / theta,
            FisheyeProjection::Equidistant | FisheyeProjection::Equisolid => 1.0,
            FisheyeProjection::Stereographic => (0.5 * theta).cos().powi(4),
            FisheyeProjection::Orthographic => 1.0 / theta.cos(),
        }
    }

    #[test]
    fn radii_are_those_of_the_papers_and_caps_their_solid_angles() {
        for (projection, half, lens) in lenses() {
            for k in 0..=20 {
                let theta = half * f64::from(k) / 20.0;
                // Half of 360 degrees may round beyond the rim.
                let r = lens.radius(theta / PI).unwrap_or(1.0);
                let expected = papers_radius(projection, theta) / papers_radius(projection, half);
                assert!((r - expected).abs() < 1e-14, "{projection} {half} at {theta}: {r} against {expected}");
                // At the rim of an orthographic lens 1 - cos θ is a root of the distance to it.
                let (cap, expected) = (lens.cap(r), 1.0 - theta.cos());
                assert!((cap - expected).abs() < 1e-7, "{projection} {half} at {theta}: {cap} against {expected}");
            }
            assert_eq!(lens.radius(half / PI + 0.01), None, "{projection} beyond {half}");
        }
    }

    #[test]
    fn stereographic_lenses_are_right_up_to_their_limit() {
        // What the last bits of an angle near 180 degrees are worth.
        const LAST_BITS: f64 = 2e-15;
        for missing in [1.0, 1e-3, 1e-6, 1e-7] {
            let half = 0.5 * (360.0_f64 - missing).to_radians();
            let lens = Lens::new(FisheyeProjection::Stereographic, 2.0 * half).unwrap();
            let limit = 1e-14 + LAST_BITS / (PI - half);
            for theta in [0.01, 1.0, FRAC_PI_2, 3.0, 0.5 * (3.0 + half), half] {
                // Half of the field of view may round beyond the rim.
                let r = lens.radius(theta / PI).unwrap_or(1.0);
                let [expected, whole] = [theta, half].map(|t| papers_radius(FisheyeProjection::Stereographic, t));
                let error = (r * whole / expected - 1.0).abs();
                assert!(error < limit, "{missing}° from 360° at {theta}: off by {error:.1e} of {limit:.1e}");
            }
        }
    }

    #[test]
    fn solid_angles_of_pixels_are_the_density_at_their_middles_times_their_areas() {
        const SIDE: f64 = 1e-3;
        for (projection, half, lens) in lenses() {
            let f = 1.0 / papers_radius(projection, half);
            for (x, y) in [(0.0, 0.0), (0.3, 0.0), (0.0, -0.5), (-0.4, 0.4), (0.6, -0.7)] {
                let around = |c: f64| [c - 0.5 * SIDE, c + 0.5 * SIDE];
                let found = lens.solid_angle(&Rect { x: around(x), y: around(y) });
                // The angle at which the radius is that of the pixel, by bisection.
                let (mut low, mut high) = (0.0, half);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    let is_inside = f * papers_radius(projection, middle) < x.hypot(y);
                    (low, high) = if is_inside { (middle, high) } else { (low, middle) };
                }
                let expected = papers_density(projection, low) * SIDE * SIDE / (f * f);
                let error = (found / expected - 1.0).abs();
                assert!(error < 1e-4, "{projection} {half} at ({x}, {y}): {found} against {expected}");
            }
        }
    }

    #[test]
    fn solid_angles_of_pixels_sum_to_that_of_the_field_of_view() {
        for (projection, half, lens) in lenses() {
            for n in [1, 2, 7, 30] {
                let at = |i: usize| (2 * i) as f64 / n as f64 - 1.0;
                let pixel = |i: usize| Rect { x: [at(i % n), at(i % n + 1)], y: [at(i / n), at(i / n + 1)] };
                let sum: f64 = (0..n * n).map(|i| lens.solid_angle(&pixel(i))).sum();
                let expected = 2.0 * PI * (1.0 - half.cos());
                assert!((sum - expected).abs() < 1e-7, "{projection} {half}, {n} x {n}: {sum} against {expected}");
            }
        }
    }

    #[test]
    fn fields_of_view_have_the_limits_of_their_projection() {
        let allows =
            |projection: FisheyeProjection, degrees: f64| projection.check_field_of_view(degrees.to_radians()).is_ok();
        for projection in FisheyeProjection::ALL {
            assert_eq!(FisheyeProjection::from_name(projection.name()), Some(projection), "{projection}");
            for degrees in [0.0, -1.0, f64::NAN, f64::INFINITY, 361.0] {
                assert!(!allows(projection, degrees), "{projection} of {degrees}");
            }
            assert!(allows(projection, 0.1) && allows(projection, 180.0), "{projection} of 0.1° and 180°");
            let is_orthographic = projection == FisheyeProjection::Orthographic;
            assert_eq!(allows(projection, 181.0), !is_orthographic, "{projection} of 181°");
            let is_whole = matches!(projection, FisheyeProjection::Equidistant | FisheyeProjection::Equisolid);
            assert_eq!(allows(projection, 360.0), is_whole, "{projection} of 360°");
        }
        let error = FisheyeProjection::Orthographic.check_field_of_view(200_f64.to_radians()).unwrap_err().to_string();
        assert_eq!(error, "the field of view of orthographic fisheyes is above 0° and at most 180°, and 200° is not");
    }
}
