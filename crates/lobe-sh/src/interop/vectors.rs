//! Directions, colors, expansions and rotations from and to the vectors of `glam` and `mint` (features of these names), and
//! through `mint` those of most vector libraries.

use crate::error::ShError;
use crate::expansion::Sh;
use crate::rotation::Rotation;
use crate::scalar::Rgb;
use crate::sphere::Dir;

macro_rules! vectors {
    ($vector:ty, $number:ident) => {
        impl TryFrom<$vector> for Dir {
            type Error = ShError;

            fn try_from(v: $vector) -> Result<Self, ShError> {
                Self::try_from(<[$number; 3]>::from(v))
            }
        }

        impl From<Dir> for $vector {
            fn from(s: Dir) -> Self {
                s.to_array().map(|c| c as $number).into()
            }
        }

        impl From<$vector> for Rgb<$number> {
            fn from(v: $vector) -> Self {
                <[$number; 3]>::from(v).into()
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
                f.to_array().map(<$vector>::from)
            }
        }
    };
}

macro_rules! rotations {
    ($($other:ty: |$given:ident| $read:expr, |$rotation:ident| $write:expr;)*) => {$(
        impl TryFrom<$other> for Rotation {
            type Error = ShError;

            fn try_from($given: $other) -> Result<Self, ShError> {
                $read
            }
        }

        impl From<Rotation> for $other {
            fn from($rotation: Rotation) -> Self {
                $write
            }
        }
    )*};
}

#[cfg(feature = "glam")]
macro_rules! glam_rotations {
    ($quaternion:ident, $matrix:ident, $number:ident) => {
        rotations! {
            glam::$quaternion: |q| Self::from_quaternion(q.to_array().map(f64::from)),
                |rotation| Self::from_array(rotation.to_quaternion().map(|c| c as $number));
            glam::$matrix: |m| Self::from_matrix(m.transpose().to_cols_array_2d().map(|row| row.map(f64::from))),
                |rotation| Self::from_cols_array_2d(&rotation.matrix().map(|row| row.map(|c| c as $number))).transpose();
        }
    };
}

#[cfg(feature = "glam")]
vectors!(glam::Vec3, f32);
#[cfg(feature = "glam")]
vectors!(glam::DVec3, f64);
#[cfg(feature = "glam")]
glam_rotations!(Quat, Mat3, f32);
#[cfg(feature = "glam")]
glam_rotations!(DQuat, DMat3, f64);

#[cfg(feature = "mint")]
vectors!(mint::Vector3<f32>, f32);
#[cfg(feature = "mint")]
vectors!(mint::Vector3<f64>, f64);
#[cfg(feature = "mint")]
rotations! {
    mint::Quaternion<f64>: |q| Self::from_quaternion(q.into()), |rotation| rotation.to_quaternion().into();
    mint::RowMatrix3<f64>: |m| Self::from_matrix(m.into()), |rotation| rotation.matrix().into();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(feature = "glam")]
    #[test]
    fn directions_and_colors_round_trip_through_glam() {
        use glam::{DVec3, Vec3};

        let s = Dir::from_angles(0.7, -2.0);
        assert!(Dir::try_from(DVec3::from(s) * 5.0).unwrap().angle_to(s) < 1e-15, "{s:?}");
        assert!(Dir::try_from(Vec3::from(s)).unwrap().angle_to(s) < 1e-7, "{s:?}");
        assert!(Dir::try_from(Vec3::ZERO).is_err(), "zero is no direction");
        let light = crate::ShL1::impulse(s, Rgb::new(1.0_f32, 0.5, 0.25));
        assert_eq!(crate::ShL1::from(<[Vec3; 4]>::from(light)), light, "rows");
    }

    #[cfg(feature = "glam")]
    #[test]
    fn rotations_turn_vectors_as_glam_does() {
        use glam::{DMat3, DQuat, DVec3, Mat3, Quat, Vec3};

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

    #[cfg(feature = "mint")]
    #[test]
    fn values_round_trip_through_mint() {
        use mint::{Quaternion, RowMatrix3, Vector3};

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
