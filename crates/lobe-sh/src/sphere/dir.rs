//! A unit direction.

use core::ops::Neg;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::error::ShError;

/// The tolerance of the squared length given to [`Dir::from_unit`]: directions that went through a few `f64` operations
/// pass, those rounded to `f32` do not.
const UNIT_TOLERANCE: f64 = 1e-9;

/// A direction: a unit vector in Lobe's right-handed frame, +z up.
///
/// Spherical angles are `θ` from +z and `φ` from +x towards +y:
///
/// ```text
///   (x, y, z) = (sin θ cos φ, sin θ sin φ, cos θ)      φ = y.atan2(x)
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dir {
    v: [f64; 3],
}

impl Dir {
    /// +x.
    pub const X: Self = Self { v: [1.0, 0.0, 0.0] };
    /// +y.
    pub const Y: Self = Self { v: [0.0, 1.0, 0.0] };
    /// +z, the polar axis.
    pub const Z: Self = Self { v: [0.0, 0.0, 1.0] };

    /// The direction of the vector `v`; `None` if `v` is zero or not finite.
    ///
    /// `v` may have any length: components are first divided by the largest, so that nothing overflows or underflows.
    #[inline]
    #[must_use]
    pub fn new(v: [f64; 3]) -> Option<Self> {
        let largest = v[0].abs().max(v[1].abs()).max(v[2].abs());
        if !v.iter().all(|c| c.is_finite()) || largest == 0.0 {
            return None;
        }
        let [x, y, z] = v.map(|c| c / largest);
        let length = (x * x + y * y + z * z).sqrt();
        Some(Self { v: [x / length, y / length, z / length] })
    }

    /// The direction of the vector `v`; `None` if `v` is zero or not finite.
    #[inline]
    #[must_use]
    pub fn from_f32(v: [f32; 3]) -> Option<Self> {
        Self::new(v.map(f64::from))
    }

    /// The direction at angle `theta` from +z and `phi` from +x towards +y, in radians, both finite.
    #[must_use]
    pub fn from_angles(theta: f64, phi: f64) -> Self {
        let (sin_theta, cos_theta) = theta.sin_cos();
        let (sin_phi, cos_phi) = phi.sin_cos();
        Self { v: [sin_theta * cos_phi, sin_theta * sin_phi, cos_theta] }
    }

    /// A vector that the caller knows to have unit length.
    ///
    /// # Panics
    /// In debug builds, if the squared length is not 1 to 1e-9.
    #[inline]
    #[must_use]
    pub fn from_unit(v: [f64; 3]) -> Self {
        debug_assert!(
            (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - 1.0).abs() < UNIT_TOLERANCE,
            "not a unit vector: {v:?}"
        );
        Self { v }
    }

    /// The x component.
    #[inline(always)]
    #[must_use]
    pub fn x(self) -> f64 {
        self.v[0]
    }

    /// The y component.
    #[inline(always)]
    #[must_use]
    pub fn y(self) -> f64 {
        self.v[1]
    }

    /// The z component.
    #[inline(always)]
    #[must_use]
    pub fn z(self) -> f64 {
        self.v[2]
    }

    /// The components.
    #[inline(always)]
    #[must_use]
    pub fn to_array(self) -> [f64; 3] {
        self.v
    }

    /// The angle from +z, in `[0, π]`; accurate at the poles too.
    #[must_use]
    pub fn theta(self) -> f64 {
        self.v[0].hypot(self.v[1]).atan2(self.v[2])
    }

    /// The angle from +x towards +y, in `(-π, π]`; 0 at the poles.
    #[must_use]
    pub fn phi(self) -> f64 {
        // Adding 0 makes 0 of -0, which `atan2` would take for the other side of the seam.
        (self.v[1] + 0.0).atan2(self.v[0] + 0.0)
    }

    /// The cosine of the angle between two directions.
    #[inline]
    #[must_use]
    pub fn dot(self, other: Self) -> f64 {
        self.v[0] * other.v[0] + self.v[1] * other.v[1] + self.v[2] * other.v[2]
    }

    /// The angle between two directions in `[0, π]`, accurate for small and for nearly straight angles.
    ///
    /// ```text
    ///   2 atan2(|a - b|, |a + b|)
    /// ```
    #[must_use]
    pub fn angle_to(self, other: Self) -> f64 {
        let length = |f: fn(f64, f64) -> f64| {
            let [x, y, z] = [0, 1, 2].map(|k| f(self.v[k], other.v[k]));
            (x * x + y * y + z * z).sqrt()
        };
        2.0 * length(|a, b| a - b).atan2(length(|a, b| a + b))
    }
}

/// From a vector of any length; an error if it is zero or not finite.
impl TryFrom<[f64; 3]> for Dir {
    type Error = ShError;

    fn try_from(v: [f64; 3]) -> Result<Self, ShError> {
        Self::new(v).ok_or_else(|| ShError::Options(format!("expected a direction, found the vector {v:?}")))
    }
}

/// From a vector of any length; an error if it is zero or not finite.
impl TryFrom<[f32; 3]> for Dir {
    type Error = ShError;

    fn try_from(v: [f32; 3]) -> Result<Self, ShError> {
        Self::try_from(v.map(f64::from))
    }
}

impl From<Dir> for [f64; 3] {
    fn from(s: Dir) -> Self {
        s.v
    }
}

impl Neg for Dir {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { v: self.v.map(|c| -c) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_normalize_vectors_of_any_length() {
        for scale in [1e-300, 1e-160, 1.0, 1e160, 1e300] {
            let d = Dir::new([3.0 * scale, 0.0, -4.0 * scale]).unwrap();
            assert!((d.x() - 0.6).abs() < 1e-15 && (d.z() + 0.8).abs() < 1e-15, "scale {scale}: {d:?}");
        }
    }

    #[test]
    fn zero_and_non_finite_vectors_are_no_direction() {
        for v in [[0.0; 3], [f64::NAN, 0.0, 1.0], [f64::INFINITY, 0.0, 0.0]] {
            assert_eq!(Dir::new(v), None, "{v:?}");
        }
    }

    #[test]
    fn angles_round_trip_over_the_whole_sphere() {
        for theta in [1e-9, 0.3, 1.5, 2.9, core::f64::consts::PI - 1e-9] {
            for phi in [-3.1, -1.0, 0.0, 0.5, 3.1] {
                let d = Dir::from_angles(theta, phi);
                assert!((d.theta() - theta).abs() < 1e-15, "theta {theta} became {}", d.theta());
                assert!((d.phi() - phi).abs() < 1e-15, "phi {phi} became {}", d.phi());
            }
        }
    }

    #[test]
    fn the_azimuth_does_not_depend_on_the_sign_of_zero() {
        for (s, phi) in [
            (-Dir::X, core::f64::consts::PI),
            (Dir::from_unit([-0.6, -0.0, 0.8]), core::f64::consts::PI),
            (Dir::Z, 0.0),
            (-Dir::Z, 0.0),
            (Dir::from_unit([-0.0, 0.0, -1.0]), 0.0),
        ] {
            assert_eq!(s.phi(), phi, "{s:?}");
        }
    }

    #[test]
    fn small_and_straight_angles_keep_their_digits() {
        let d = Dir::from_angles(1.0, 2.0);
        let near = Dir::from_angles(1.0 + 1e-10, 2.0);
        assert!((d.angle_to(near) / 1e-10 - 1.0).abs() < 1e-5, "{}", d.angle_to(near));
        assert!((d.angle_to(-d) - core::f64::consts::PI).abs() < 1e-15, "{}", d.angle_to(-d));
    }
}
