//! Handedness of cubes: for which directions their faces were made.

/// The handedness of the directions with which a cube map is looked up.
///
/// Graphics interfaces define faces and their orientation once, for a direction `(X, Y, Z)` with Y up (see
/// [`cube`](crate::cube)). Whether that direction is right- or left-handed is up to the program, and a cube made for
/// one kind of program is the mirror image of the cube for the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum CubeHandedness {
    /// For right-handed directions, `(X, Y, Z) = (x, z, -y)`: glTF, OpenGL, Vulkan, Filament. The faces are mirror
    /// images of photographs. [`CubeMap`](crate::CubeMap) itself is this one.
    #[default]
    Right,
    /// For left-handed directions, `(X, Y, Z) = (-x, z, -y)`: Direct3D, and three.js, which turns X around before it
    /// looks a cube up. The faces are photographs taken in the center: letters can be read.
    Left,
}

impl CubeHandedness {
    /// The name by which a file keeps that the faces of its cube are left-handed, in the place of its mapping's
    /// ([`PictureWriteOptions::mapping`](lobe_image::PictureWriteOptions::mapping)), so that
    /// [`read_map`](crate::read_map()) turns them around again. Right-handed ones need none.
    #[must_use]
    pub fn mapping_name(self) -> Option<&'static str> {
        (self == Self::Left).then_some("cube-left-handed")
    }

    /// The name by which a picture keeps the handedness of its cube, right or left: [`read_map`](crate::read_map())
    /// need not assume one.
    #[must_use]
    pub fn told_name(self) -> &'static str {
        self.mapping_name().unwrap_or("cube-right-handed")
    }

    /// Whether a file says for which handedness the faces of its cube are.
    pub(crate) fn is_told(mapping: Option<&str>) -> bool {
        [Self::Right, Self::Left].iter().any(|handedness| mapping == Some(handedness.told_name()))
    }

    /// Whether a file says that the faces of its cube are left-handed.
    pub(crate) fn is_left(mapping: Option<&str>) -> bool {
        mapping.is_some() && mapping == Self::Left.mapping_name()
    }
}
