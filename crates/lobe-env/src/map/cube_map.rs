//! Cube maps.

use lobe_sh::{Dir, Rgb};

use crate::error::EnvError;
use crate::map::mapped_map::MappedMap;
use crate::map::mapped_map::of_one_mapping;
use crate::mapping::cube::{self, FACES};
use crate::mapping::mapping::Mapping;

/// The radiance from every direction, as the six square faces of a cube.
///
/// Faces, order and handedness are those of OpenGL, Vulkan, KTX2 and DDS, looked up with the y-up direction
/// `(x, z, -y)`; [`cube`] has the table. Linear light, like [`EnvMap`](crate::EnvMap). It is a [`MappedMap`], and lends
/// itself as one: the texels of all faces, the radiance from a direction (continuous across edges and corners), the mean.
///
/// ```
/// use lobe_env::CubeMap;
/// use lobe_sh::{Dir, Rgb};
///
/// let cube = CubeMap::from_fn(4, |s| Rgb::new(s.x() as f32, s.y() as f32, s.z() as f32));
/// // Face 2, the cube's +Y, is Lobe's +z: up.
/// assert!(cube.texel(2, 1, 1).b > 0.9);
/// assert!(cube.radiance(Dir::Z).b > 0.9);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CubeMap(MappedMap);

impl CubeMap {
    /// A map from the texels of its faces, face after face (+X, -X, +Y, -Y, +Z, -Z of the cube), row after row.
    ///
    /// # Errors
    /// [`EnvError::Options`] if `size` is 0 or too large, or `texels` has any other length than `6 size²`.
    pub fn new(size: usize, texels: Vec<Rgb<f32>>) -> Result<Self, EnvError> {
        Self::check_size(size)?;
        let expected = size.checked_mul(size).and_then(|n| n.checked_mul(FACES));
        if expected != Some(texels.len()) {
            let found = texels.len();
            return Err(EnvError::Options(format!("6 faces of {size} x {size} texels expected, {found} texels given")));
        }
        Ok(Self(MappedMap::from_rows(Mapping::Cube, size, FACES * size, texels)))
    }

    /// Fails if there can be no cube of this size.
    pub(crate) fn check_size(size: usize) -> Result<(), EnvError> {
        if size == 0 {
            return Err(EnvError::Options("a cube map needs texels, but its faces have a size of 0".to_owned()));
        }
        MappedMap::check(Mapping::Cube, size, FACES.saturating_mul(size))
    }

    /// A map from its six faces, each row after row.
    ///
    /// # Errors
    /// [`EnvError::Options`] if `size` is 0 or a face has any other length than `size²`.
    pub fn from_faces(size: usize, faces: &[Vec<Rgb<f32>>; FACES]) -> Result<Self, EnvError> {
        if let Some((f, face)) = faces.iter().enumerate().find(|(_, face)| size.checked_mul(size) != Some(face.len())) {
            let found = face.len();
            return Err(EnvError::Options(format!("face {f}: {size} x {size} texels expected, {found} given")));
        }
        Self::new(size, faces.concat())
    }

    /// The map whose texels have the value of `radiance` towards their centers.
    ///
    /// # Panics
    /// If there can be no cube of this size: if `size` is 0, or its texels are more than `u32::MAX`.
    #[must_use]
    pub fn from_fn(size: usize, radiance: impl Fn(Dir) -> Rgb<f32> + Sync) -> Self {
        if let Err(error) = Self::check_size(size) {
            panic!("{error}");
        }
        Self(MappedMap::from_fn(Mapping::Cube, size, FACES * size, radiance))
    }

    /// The number of texels along the edge of a face, at least 1.
    #[must_use]
    pub fn size(&self) -> usize {
        self.0.width()
    }

    /// The texels of a face, row after row.
    ///
    /// # Panics
    /// If `face >= 6`.
    #[must_use]
    pub fn face(&self, face: usize) -> &[Rgb<f32>] {
        let count = self.size() * self.size();
        &self.texels()[face * count..][..count]
    }

    /// The texel in column `x` of row `y` of a face.
    ///
    /// # Panics
    /// If there is no such texel.
    #[must_use]
    pub fn texel(&self, face: usize, x: usize, y: usize) -> Rgb<f32> {
        assert!(x < self.size(), "no column {x} in a face of {}", self.size());
        self.face(face)[y * self.size() + x]
    }

    /// The direction of the center of a texel.
    ///
    /// # Panics
    /// If `face >= 6`.
    #[must_use]
    pub fn dir(&self, face: usize, x: usize, y: usize) -> Dir {
        cube::dir_from_face(face, (x as f64 + 0.5) / self.size() as f64, (y as f64 + 0.5) / self.size() as f64)
    }
}

of_one_mapping!(CubeMap);

impl MappedMap {
    /// The cube map of the same texels.
    ///
    /// # Errors
    /// [`EnvError::Options`] if the mapping is another.
    pub fn into_cube_map(self) -> Result<CubeMap, EnvError> {
        self.expect(Mapping::Cube)?;
        Ok(CubeMap(self))
    }
}
