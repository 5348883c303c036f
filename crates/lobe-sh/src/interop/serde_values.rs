//! Public values by `serde` (feature `serde`), beside the types that derive it.
//!
//! Directions are `[x, y, z]`, rotations and axis permutations three rows, expansions and polygons their list, and what
//! has a name is that name: a quantity `"log-visibility"`, a window `"hanning:12"`. Reading checks what a constructor
//! would check; numbers that were written come back bit for bit.

use alloc::string::{String, ToString};
use alloc::vec::Vec;

use serde::de::{Deserialize, Deserializer, Error};
use serde::{Serialize, Serializer};

use crate::encoding::h_basis::HBasis;
use crate::encoding::irradiance_encoding::IrradianceEncoding;
use crate::error::ShError;
use crate::expansion::quantity::Quantity;
use crate::expansion::{Expansion as _, Sh, ShVec};
use crate::filter::Window;
use crate::light::spherical_polygon::SphericalPolygon;
use crate::ringing::dering::DeringMethod;
use crate::rotation::Rotation;
use crate::rotation::axis_permutation::AxisPermutation;
use crate::scalar::Coefficient;
use crate::sphere::Dir;

/// The largest error of a squared length, or of an entry of `RᵀR`, that leaves a direction or a rotation as it is: some
/// roundings.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

macro_rules! by_parts {
    ($($kind:ty as $parts:ty: $write:ident, |$given:ident| $read:expr;)*) => {$(
        impl Serialize for $kind {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                self.$write().serialize(serializer)
            }
        }

        impl<'de> Deserialize<'de> for $kind {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let $given = <$parts>::deserialize(deserializer)?;
                $read.map_err(D::Error::custom)
            }
        }
    )*};
}

by_parts! {
    Dir as [f64; 3]: to_array, |v| dir(v);
    Rotation as [[f64; 3]; 3]: matrix, |rows| Self::from_matrix_within(rows, ROUNDING);
    AxisPermutation as [[i8; 3]; 3]: matrix, |rows| Self::from_matrix(rows)
        .ok_or_else(|| format!("expected one 1 or -1 in each row and column, found {rows:?}"));
    SphericalPolygon as Vec<[f64; 3]>: vertices, |vertices| Self::new(vertices);
}

/// The direction of a vector of any length; one of unit length is not changed.
fn dir(v: [f64; 3]) -> Result<Dir, ShError> {
    let square: f64 = v.iter().map(|c| c * c).sum();
    if (square - 1.0).abs() <= ROUNDING { Ok(Dir::from_unit(v)) } else { Dir::try_from(v) }
}

impl<const N: usize, T: Serialize> Serialize for Sh<N, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.coefficients[..].serialize(serializer)
    }
}

impl<'de, const N: usize, T: Deserialize<'de>> Deserialize<'de> for Sh<N, T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        exactly(Vec::deserialize(deserializer)?).map(Self::of)
    }
}

impl<T: Coefficient + Serialize> Serialize for ShVec<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.coefficients().serialize(serializer)
    }
}

impl<'de, T: Coefficient + Deserialize<'de>> Deserialize<'de> for ShVec<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let coefficients = Vec::<T>::deserialize(deserializer)?;
        let len = coefficients.len();
        Self::from_vec(coefficients).ok_or_else(|| D::Error::custom(format!("expected n² coefficients, found {len}")))
    }
}

#[derive(serde::Serialize, serde::Deserialize)]
struct HBasisFields<C> {
    coefficients: C,
    frame: Rotation,
}

impl<const N: usize, T: Serialize> Serialize for HBasis<N, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        HBasisFields { coefficients: &self.coefficients[..], frame: self.frame }.serialize(serializer)
    }
}

impl<'de, const N: usize, T: Deserialize<'de>> Deserialize<'de> for HBasis<N, T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let HBasisFields { coefficients, frame } = HBasisFields::<Vec<T>>::deserialize(deserializer)?;
        Ok(Self { coefficients: exactly(coefficients)?, frame })
    }
}

/// A list of exactly `N` items.
fn exactly<const N: usize, T, E: Error>(items: Vec<T>) -> Result<[T; N], E> {
    <[T; N]>::try_from(items).map_err(|items| E::custom(format!("expected {N} coefficients, found {}", items.len())))
}

macro_rules! by_text {
    ($($kind:ty),*) => {$(
        impl Serialize for $kind {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(&self.to_string())
            }
        }

        impl<'de> Deserialize<'de> for $kind {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
            }
        }
    )*};
}

by_text!(DeringMethod, IrradianceEncoding, Quantity, Window);

#[cfg(test)]
mod tests {
    use std::fmt::Debug;

    use super::*;
    use crate::encoding::ahd::Ahd;
    use crate::encoding::ambient_cube::AmbientCube;
    use crate::encoding::irradiance_encoding::EncodedIrradiance;
    use crate::expansion::{ShL1, ShL2, Zonal};
    use crate::light::Light;
    use crate::light::normalization::Normalization;
    use crate::light_extraction::extract::{LightFitOptions, extract_light};
    use crate::projection::monte_carlo::MonteCarloOptions;
    use crate::projection::project;
    use crate::scalar::Rgb;
    use serde::de::DeserializeOwned;

    #[track_caller]
    fn assert_round_trip<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: &T, expected: &str) {
        let text = serde_json::to_string(value).unwrap();
        assert!(expected.is_empty() || text == expected, "{text} against {expected}");
        assert_eq!(&serde_json::from_str::<T>(&text).unwrap(), value, "{text}");
    }

    #[test]
    fn values_come_back_bit_for_bit() {
        for v in lobe_testkit::directions() {
            let rotation = Rotation::from_axis_angle(Dir::from_unit(v), 0.7);
            assert_round_trip(&rotation, "");
            assert_round_trip(&rotation.rotate_dir(Dir::Y), "");
        }
        assert_round_trip(&Dir::Z, "[0.0,0.0,1.0]");
        assert_round_trip(&AxisPermutation::Z_UP_FROM_Y_UP, "[[1,0,0],[0,0,-1],[0,1,0]]");
        assert_round_trip(&Quantity::LogVisibility, "\"log-visibility\"");
        assert_round_trip(&Window::Lanczos { width: 9.5, power: 4.0 }, "\"lanczos:9.5:4\"");
        assert_round_trip(&DeringMethod::Table, "\"table\"");
        assert_round_trip(&Zonal::clamped_cosine(2), "");
        assert_round_trip(&ShL1::impulse(Dir::X, Rgb::new(1.0, 0.5, 2.0)), "");
        assert_round_trip(&Normalization::Analytic, "\"analytic\"");
        assert_round_trip(&MonteCarloOptions::default(), "");
        assert_round_trip(&LightFitOptions::default(), "");
    }

    #[test]
    fn lights_and_encodings_come_back() {
        let color = Rgb::new(1.0, 0.5, 0.25);
        assert_round_trip(
            &Light::Directional { dir: Dir::X, color },
            r#"{"kind":"directional","dir":[1.0,0.0,0.0],"color":[1.0,0.5,0.25]}"#,
        );
        let polygon = SphericalPolygon::new(vec![[1.0, 0.0, 3.0], [0.0, 1.0, 3.0], [-1.0, -1.0, 3.0]]).unwrap();
        assert_round_trip(&Light::Polygon { polygon, color }, "");
        let irradiance = project(3, 2, |s| Rgb::new(3.0 + s.x(), 2.0 + s.y() * s.z(), 4.0 - s.z()));
        assert_round_trip(&extract_light(&irradiance).unwrap(), "");
        assert_round_trip(&AmbientCube::from_irradiance_sh(&irradiance), "");
        assert_round_trip(&Ahd::solved(&irradiance), "");
        for encoding in IrradianceEncoding::ALL {
            assert_round_trip(&encoding, &format!("\"{}\"", encoding.name()));
            let encoded: EncodedIrradiance<Rgb<f64>> = encoding.encode(&irradiance, Rotation::IDENTITY);
            assert_round_trip(&encoded, "");
        }
    }

    #[test]
    fn values_that_no_constructor_accepts_are_refused() {
        for (text, refused) in [
            ("[0,0,0]", serde_json::from_str::<Dir>("[0,0,0]").is_err()),
            ("a mirror", serde_json::from_str::<Rotation>("[[1,0,0],[0,1,0],[0,0,-1]]").is_err()),
            ("two in a row", serde_json::from_str::<AxisPermutation>("[[1,1,0],[0,0,1],[0,1,0]]").is_err()),
            ("eight rows", serde_json::from_str::<ShL2<f64>>("[1,2,3,4,5,6,7,8]").is_err()),
            ("five rows", serde_json::from_str::<ShVec<f64>>("[1,2,3,4,5]").is_err()),
            ("two vertices", serde_json::from_str::<SphericalPolygon>("[[1,0,0],[0,1,0]]").is_err()),
            ("no window", serde_json::from_str::<Window>("\"hanning:-1\"").is_err()),
        ] {
            assert!(refused, "{text} was taken");
        }
    }
}
