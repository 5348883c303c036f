//! Layouts of the six faces of a cube in one picture or six.

use lobe_image::Picture;
use lobe_sh::Rgb;

use crate::error::EnvError;
use crate::map::cube_handedness::CubeHandedness;
use crate::map::cube_map::CubeMap;
use crate::map::cube_mip_chain::CubeMipChain;
use crate::map::face_order::{FaceNames, FaceOrder};
use crate::mapping::cube::FACES;

/// The faces of a cube in one picture.
///
/// The cube's own names of the faces. In all layouts every face stands upright, except that the vertical cross turns -Z
/// by half a turn, as it is folded.
///
/// ```text
///   HorizontalCross     VerticalCross    Row                          Column
///
///        +Y                  +Y          +X -X +Y -Y +Z -Z            +X
///    -X  +Z  +X  -Z      -X  +Z  +X      Sheet3x2  Sheet2x3           -X
///        -Y                  -Y          +X -X +Y  +X -X              ..
///                            -Z (turned) -Y +Z -Z  ...                -Z
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum CubeLayout {
    /// Four faces wide, three high.
    HorizontalCross,
    /// Three faces wide, four high.
    VerticalCross,
    /// Six faces side by side, in order.
    Row,
    /// Six faces below each other, in order.
    Column,
    /// Two rows of three faces, in order. Photographs have these proportions too, so that they alone tell no cube.
    Sheet3x2,
    /// Three rows of two faces, in order; likewise.
    Sheet2x3,
}

impl CubeLayout {
    /// The layouts that proportions tell.
    pub const ALL: [Self; 4] = [Self::HorizontalCross, Self::VerticalCross, Self::Row, Self::Column];

    /// Columns and rows, in faces.
    #[must_use]
    pub fn shape(self) -> (usize, usize) {
        match self {
            Self::HorizontalCross => (4, 3),
            Self::VerticalCross => (3, 4),
            Self::Row => (FACES, 1),
            Self::Column => (1, FACES),
            Self::Sheet3x2 => (3, 2),
            Self::Sheet2x3 => (2, 3),
        }
    }

    /// The layout of a picture, told by its proportions.
    ///
    /// # Errors
    /// [`EnvError::Options`] if no layout has them.
    pub fn of_picture(width: usize, height: usize) -> Result<Self, EnvError> {
        Self::ALL.into_iter().find(|layout| layout.fits(width, height)).ok_or_else(|| {
            let shapes = "4:3 (horizontal cross), 3:4 (vertical cross), 6:1 (row) or 1:6 (column)";
            EnvError::Options(format!("a picture of a cube is {shapes}, but this is {width} x {height}"))
        })
    }

    /// The layout of a picture that is known to be a cube: a sheet of 3:2 or 2:3 too.
    ///
    /// # Errors
    /// [`EnvError::Options`] if no layout has its proportions.
    pub fn of_cube_picture(width: usize, height: usize) -> Result<Self, EnvError> {
        let sheet = [Self::Sheet3x2, Self::Sheet2x3].into_iter().find(|layout| layout.fits(width, height));
        sheet.map_or_else(|| Self::of_picture(width, height), Ok)
    }

    fn fits(self, width: usize, height: usize) -> bool {
        let (columns, rows) = self.shape();
        width > 0 && width.is_multiple_of(columns) && width / columns * rows == height
    }

    /// Whether its form tells which face is where.
    fn is_folded(self) -> bool {
        matches!(self, Self::HorizontalCross | Self::VerticalCross)
    }

    /// Column, row and half turn of a face.
    fn place(self, face: usize) -> (usize, usize, bool) {
        match self {
            Self::Row => (face, 0, false),
            Self::Column => (0, face, false),
            Self::Sheet3x2 | Self::Sheet2x3 => (face % self.shape().0, face / self.shape().0, false),
            Self::HorizontalCross => {
                let (column, row) = [(2, 1), (0, 1), (1, 0), (1, 2), (1, 1), (3, 1)][face];
                (column, row, false)
            }
            Self::VerticalCross => {
                let (column, row) = [(2, 1), (0, 1), (1, 0), (1, 2), (1, 1), (1, 3)][face];
                (column, row, face == 5)
            }
        }
    }
}

impl CubeMap {
    /// The map with its faces as `handedness` wants them, or the map of faces that were made so: the way there is also
    /// the way back. [`Left`](CubeHandedness::Left) turns X around, [`Right`](CubeHandedness::Right) changes nothing.
    #[must_use]
    pub fn of_handedness(mut self, handedness: CubeHandedness) -> Self {
        if handedness == CubeHandedness::Left {
            let size = self.size();
            mirror(size, self.texels_mut());
        }
        self
    }

    /// The six faces in the order +X, -X, +Y, -Y, +Z, -Z, each row after row, for six files or a graphics interface.
    #[must_use]
    pub fn faces(&self, handedness: CubeHandedness) -> [Vec<Rgb<f32>>; FACES] {
        let map = self.clone().of_handedness(handedness);
        [0, 1, 2, 3, 4, 5].map(|face| map.face(face).to_vec())
    }

    /// The map of six faces, the inverse of [`faces`](Self::faces).
    ///
    /// # Errors
    /// [`EnvError::Options`] if `size` is 0 or a face has any other length than `size²`.
    pub fn from_handed_faces(
        size: usize,
        faces: &[Vec<Rgb<f32>>; FACES],
        handedness: CubeHandedness,
    ) -> Result<Self, EnvError> {
        Ok(Self::from_faces(size, faces)?.of_handedness(handedness))
    }

    /// All faces in one picture; the corners of a cross are black.
    #[must_use]
    pub fn to_picture(&self, layout: CubeLayout, handedness: CubeHandedness) -> Picture {
        let size = self.size();
        let (columns, rows) = layout.shape();
        let (width, height) = (columns * size, rows * size);
        let mut picture = Picture::filled(width, height, [0.0; 3]);
        let texels = picture.pixels_mut();
        for (face, pixels) in self.faces(handedness).iter().enumerate() {
            let (column, row, turned) = layout.place(face);
            for (i, texel) in pixels.iter().enumerate() {
                let i = if turned { size * size - 1 - i } else { i };
                texels[(row * size + i / size) * width + column * size + i % size] = texel.to_array();
            }
        }
        picture
    }

    /// The map in a picture of all faces, whose [layout](CubeLayout::of_cube_picture) its proportions tell.
    ///
    /// # Errors
    /// [`EnvError::Options`] if the proportions are wrong.
    pub fn from_picture(picture: &Picture, handedness: CubeHandedness) -> Result<Self, EnvError> {
        Self::from_picture_in_order(picture, &FaceOrder::usual(FaceNames::Axes), handedness)
    }

    /// The map in a picture of all faces, which stand in this order, row after row. A cross tells by itself which face
    /// is where: there the order only says whether they are photographs.
    ///
    /// # Errors
    /// [`EnvError::Options`] if the proportions are wrong.
    pub fn from_picture_in_order(
        picture: &Picture,
        order: &FaceOrder,
        handedness: CubeHandedness,
    ) -> Result<Self, EnvError> {
        let (width, height, texels) = (picture.width(), picture.height(), picture.pixels());
        let layout = CubeLayout::of_cube_picture(width, height)?;
        let order = if layout.is_folded() { FaceOrder::usual(order.names()) } else { *order };
        let size = width / layout.shape().0;
        let faces = [0, 1, 2, 3, 4, 5].map(|face| {
            let (column, row, turned) = layout.place(face);
            let at = |i: usize| Rgb::from(texels[(row * size + i / size) * width + column * size + i % size]);
            (0..size * size).map(|i| at(if turned { size * size - 1 - i } else { i })).collect()
        });
        order.cube(size, faces, handedness)
    }
}

impl CubeMipChain {
    /// Every level as [`CubeMap::of_handedness`].
    #[must_use]
    pub fn of_handedness(mut self, handedness: CubeHandedness) -> Self {
        if handedness == CubeHandedness::Left {
            for level in self.levels_mut() {
                let size = level.size();
                mirror(size, level.texels_mut());
            }
        }
        self
    }
}

/// Turns X around: +X and -X change places, and every face its left and right.
fn mirror(size: usize, texels: &mut [Rgb<f32>]) {
    let (plus_x, rest) = texels.split_at_mut(size * size);
    plus_x.swap_with_slice(&mut rest[..size * size]);
    texels.chunks_exact_mut(size).for_each(<[_]>::reverse);
}
