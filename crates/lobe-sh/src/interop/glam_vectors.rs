//! Directions, colors, expansions and rotations from and to `glam` (feature `glam`).

use glam::{DMat3, DQuat, DVec3, Mat3, Quat, Vec3};

use crate::{Dir, Rgb, Rotation, RotationError, Sh, ShError};

/// Vectors of one precision.
macro_rules! vectors {
    ($vector:ident, $number:ident) => {
        impl TryFrom<$vector> for Dir {
            type Error = ShError;

            /// The direction of a vector of any length; an error if it is zero or not finite.
            fn try_from(v: $vector) -> Result<Self, ShError> {
                Self::try_from(v.to_array())
            }
        }

        impl From<Dir> for $vector {
            fn from(s: Dir) -> Self {
                s.to_array().map(|c| c as $number).into()
            }
        }

        impl From<$vector> for Rgb<$number> {
            fn from(v: $vector) -> Self {
                v.to_array().into()
            }
        }

        impl From<Rgb<$number>> for $vector {
            fn from(c: Rgb<$number>) -> Self {
                c.to_array().into()
            }
        }

        impl<const N: usize> From<[$vector; N]> for Sh<N, Rgb<$number>> {
            fn from(rows: [$vector; N]) -> Self {
                Self::from(rows.map(Rgb::from))
            }
        }

        impl<const N: usize> From<Sh<N, Rgb<$number>>> for [$vector; N] {
            fn from(f: Sh<N, Rgb<$number>>) -> Self {
                f.to_array().map($vector::from)
            }
        }
    };
}

vectors!(Vec3, f32);
vectors!(DVec3, f64);

/// Rotations of one precision.
macro_rules! rotations {
    ($quaternion:ident, $matrix:ident, $number:ident) => {
        impl TryFrom<$quaternion> for Rotation {
            type Error = RotationError;

            fn try_from(q: $quaternion) -> Result<Self, RotationError> {
                Self::from_quaternion(q.to_array().map(f64::from))
            }
        }

        impl From<Rotation> for $quaternion {
            fn from(rotation: Rotation) -> Self {
                Self::from_array(rotation.to_quaternion().map(|c| c as $number))
            }
        }

        impl TryFrom<$matrix> for Rotation {
            type Error = RotationError;

            fn try_from(m: $matrix) -> Result<Self, RotationError> {
                Self::from_matrix(m.transpose().to_cols_array_2d().map(|row| row.map(f64::from)))
            }
        }

        impl From<Rotation> for $matrix {
            fn from(rotation: Rotation) -> Self {
                Self::from_cols_array_2d(&rotation.matrix().map(|row| row.map(|c| c as $number))).transpose()
            }
        }
    };
}

rotations!(Quat, Mat3, f32);
rotations!(DQuat, DMat3, f64);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ShL1;

    #[test]
    fn directions_and_colors_round_trip_through_glam() {
        let s = Dir::from_angles(0.7, -2.0);
        assert!(Dir::try_from(DVec3::from(s) * 5.0).unwrap().angle_to(s) < 1e-15, "{s:?}");
        assert!(Dir::try_from(Vec3::from(s)).unwrap().angle_to(s) < 1e-7, "{s:?}");
        assert!(Dir::try_from(Vec3::ZERO).is_err(), "zero is no direction");
        let light = ShL1::impulse(s, Rgb::new(1.0_f32, 0.5, 0.25));
        assert_eq!(ShL1::from(<[Vec3; 4]>::from(light)), light, "rows");
    }

    #[test]
    fn rotations_turn_vectors_as_glam_does() {
        let rotation = Rotation::from_axis_angle(Dir::from_angles(1.0, 0.3), 2.2);
        let v = Dir::from_angles(2.0, -0.7);
        let expected = DVec3::from(rotation.rotate_dir(v));
        for turned in [DQuat::from(rotation) * DVec3::from(v), DMat3::from(rotation) * DVec3::from(v)] {
            assert!((turned - expected).length() < 1e-15, "{turned} against {expected}");
        }
        for back in [Rotation::try_from(DQuat::from(rotation)), Rotation::try_from(DMat3::from(rotation))] {
            let turned = DVec3::from(back.unwrap().rotate_dir(v));
            assert!((turned - expected).length() < 1e-15, "{turned} against {expected}");
        }
        let single = Vec3::from(rotation.rotate_dir(v));
        for turned in [Quat::from(rotation) * Vec3::from(v), Mat3::from(rotation) * Vec3::from(v)] {
            assert!((turned - single).length() < 1e-6, "{turned} against {single}");
        }
    }
}
