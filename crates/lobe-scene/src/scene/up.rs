//! Rotation between y-up worlds and Lobe's z-up world.

use std::ops::Neg;

/// The up axis of a file. glTF defines y; OBJ and PLY leave it open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// +y is up, as in glTF and in most modeling programs: the scene is rotated by [`z_up_from_y_up`].
    #[default]
    Y,
    /// +z is up, as in Lobe: nothing is rotated.
    Z,
}

/// A y-up vector, such as a point of a glTF file, in Lobe's z-up world: a quarter turn about x.
///
/// ```text
///   (x, y, z)_lobe = (x, -z, y)_gltf
/// ```
///
/// # Examples
///
/// ```
/// use lobe_scene::{y_up_from_z_up, z_up_from_y_up};
///
/// assert_eq!(z_up_from_y_up([0.0, 1.0, 0.0]), [0.0, 0.0, 1.0], "up stays up");
/// assert_eq!(y_up_from_z_up(z_up_from_y_up([1.0, 2.0, 3.0])), [1.0, 2.0, 3.0], "and back");
/// ```
#[must_use]
pub fn z_up_from_y_up<T: Neg<Output = T>>([x, y, z]: [T; 3]) -> [T; 3] {
    [x, -z, y]
}

/// A vector of Lobe's z-up world in a y-up one, as glTF files need it: the inverse of [`z_up_from_y_up`].
#[must_use]
pub fn y_up_from_z_up<T: Neg<Output = T>>([x, y, z]: [T; 3]) -> [T; 3] {
    [x, z, -y]
}

impl Up {
    /// A vector of a file with this axis up, in Lobe's world.
    pub(crate) fn to_world<T: Neg<Output = T>>(self, v: [T; 3]) -> [T; 3] {
        match self {
            Self::Y => z_up_from_y_up(v),
            Self::Z => v,
        }
    }
}
