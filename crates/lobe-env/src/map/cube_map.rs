//! Cube maps.

use std::borrow::Cow;

use lobe_sh::{Dir, Rgb};

use crate::mapping::cube::{self, FACES};
use crate::{EnvError, MappedMap, Mapping};

/// The radiance from every direction, as the six square faces of a cube.
///
/// Faces, order and handedness are those of OpenGL, Vulkan, KTX2 and DDS, looked up with the y-up direction
/// `(x, z, -y)`; [`cube`] has the table. Linear light, like [`EnvMap`](crate::EnvMap).
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

    /// All texels, face after face, row after row.
    #[must_use]
    pub fn texels(&self) -> &[Rgb<f32>] {
        self.0.texels()
    }

    /// All texels, to change.
    #[must_use]
    pub fn texels_mut(&mut self) -> &mut [Rgb<f32>] {
        self.0.texels_mut()
    }

    /// All texels, as a vector.
    #[must_use]
    pub fn into_texels(self) -> Vec<Rgb<f32>> {
        self.0.into_texels()
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

    /// The radiance from direction `s`, interpolated bilinearly between texel centers, across edges and corners too.
    ///
    /// Beyond its edge a face continues with the first row of its neighbor; beyond a corner with the mean of the three
    /// texels that meet there. So the value is continuous over the whole sphere
    /// (test `the_radiance_of_every_mapping_is_continuous_across_its_seams`).
    #[must_use]
    pub fn radiance(&self, s: Dir) -> Rgb<f32> {
        self.0.radiance(s)
    }

    /// The mean over the sphere, every texel weighted with its solid angle.
    #[must_use]
    pub fn mean(&self) -> Rgb<f64> {
        self.0.mean()
    }
}

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

impl AsRef<MappedMap> for CubeMap {
    fn as_ref(&self) -> &MappedMap {
        &self.0
    }
}

impl From<CubeMap> for MappedMap {
    fn from(map: CubeMap) -> Self {
        map.0
    }
}

impl<'a> From<&'a CubeMap> for Cow<'a, MappedMap> {
    fn from(map: &'a CubeMap) -> Self {
        Self::Borrowed(map.as_ref())
    }
}

impl From<CubeMap> for Cow<'_, MappedMap> {
    fn from(map: CubeMap) -> Self {
        Self::Owned(map.into())
    }
}
