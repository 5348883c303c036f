//! Directions, colors and rotations from and to `mint` (feature `mint`), and so from and to most vector libraries.

use mint::{Quaternion, RowMatrix3, Vector3};

use crate::{Dir, Real, Rgb, Rotation, RotationError, ShError};

impl TryFrom<Vector3<f64>> for Dir {
    type Error = ShError;

    /// The direction of a vector of any length; an error if it is zero or not finite.
    fn try_from(v: Vector3<f64>) -> Result<Self, ShError> {
        Self::try_from([v.x, v.y, v.z])
    }
}

impl TryFrom<Vector3<f32>> for Dir {
    type Error = ShError;

    /// The direction of a vector of any length; an error if it is zero or not finite.
    fn try_from(v: Vector3<f32>) -> Result<Self, ShError> {
        Self::try_from([v.x, v.y, v.z])
    }
}

impl From<Dir> for Vector3<f64> {
    fn from(s: Dir) -> Self {
        s.to_array().into()
    }
}

impl From<Dir> for Vector3<f32> {
    fn from(s: Dir) -> Self {
        s.to_array().map(|c| c as f32).into()
    }
}

impl<S: Real> From<Vector3<S>> for Rgb<S> {
    fn from(v: Vector3<S>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl<S: Real> From<Rgb<S>> for Vector3<S> {
    fn from(c: Rgb<S>) -> Self {
        c.to_array().into()
    }
}

impl TryFrom<Quaternion<f64>> for Rotation {
    type Error = RotationError;

    fn try_from(q: Quaternion<f64>) -> Result<Self, RotationError> {
        Self::from_quaternion([q.v.x, q.v.y, q.v.z, q.s])
    }
}

impl From<Rotation> for Quaternion<f64> {
    fn from(rotation: Rotation) -> Self {
        let [x, y, z, s] = rotation.to_quaternion();
        Self { s, v: Vector3 { x, y, z } }
    }
}

impl TryFrom<RowMatrix3<f64>> for Rotation {
    type Error = RotationError;

    fn try_from(m: RowMatrix3<f64>) -> Result<Self, RotationError> {
        Self::from_matrix(m.into())
    }
}

impl From<Rotation> for RowMatrix3<f64> {
    fn from(rotation: Rotation) -> Self {
        rotation.matrix().into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_round_trip_through_mint() {
        let s = Dir::from_angles(0.7, -2.0);
        assert!(Dir::try_from(Vector3::<f64>::from(s)).unwrap().angle_to(s) < 1e-15, "{s:?}");
        assert!(Dir::try_from(Vector3::<f32>::from(s)).unwrap().angle_to(s) < 1e-7, "{s:?}");
        assert!(Dir::try_from(Vector3 { x: 0.0_f64, y: 0.0, z: 0.0 }).is_err(), "zero is no direction");
        let c = Rgb::new(1.0_f32, 2.0, 3.0);
        assert_eq!(Rgb::from(Vector3::from(c)), c, "a color");
        let rotation = Rotation::from_axis_angle(s, 1.1);
        let by_matrix = Rotation::try_from(RowMatrix3::from(rotation)).unwrap().rotate_dir(Dir::X);
        let by_quaternion = Rotation::try_from(Quaternion::from(rotation)).unwrap().rotate_dir(Dir::X);
        let expected = rotation.rotate_dir(Dir::X);
        assert!(by_matrix.angle_to(expected) < 1e-15, "{by_matrix:?} against {expected:?}");
        assert!(by_quaternion.angle_to(expected) < 1e-15, "{by_quaternion:?} against {expected:?}");
    }
}
