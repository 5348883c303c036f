//! Environment maps in any mapping.

use std::borrow::Cow;

use lobe_io::parallel;
use lobe_sh::{Coefficient, Dir, Rgb};

use crate::error::EnvError;
use crate::mapping::grid::Grid;
use crate::mapping::mapping::Mapping;
use crate::mapping::solid_angles::SolidAngles;

/// The most texels of a map: 48 GiB, and an index of 32 bits for each.
const MOST_TEXELS: usize = u32::MAX as usize;

/// The radiance that arrives at a point from every direction, as a picture in any [`Mapping`].
///
/// An [`EnvMap`](crate::EnvMap) and a [`CubeMap`](crate::CubeMap) become one without copying a texel, and back. The
/// value of a texel that the rim of a disc cuts is that of its part inside; texels outside the discs are ignored
/// everywhere.
///
/// ```
/// use lobe_env::{MappedMap, Mapping};
/// use lobe_sh::Rgb;
///
/// let sky = MappedMap::from_fn(Mapping::Octahedral, 64, 64, |s| Rgb::new(0.5, 0.5, 1.0 + s.z() as f32));
/// assert!((sky.mean().b - 1.0).abs() < 1e-6);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MappedMap {
    mapping: Mapping,
    width: usize,
    height: usize,
    texels: Vec<Rgb<f32>>,
}

impl MappedMap {
    /// A map from its texels, row after row.
    ///
    /// # Errors
    /// [`EnvError::Options`] if a side is 0, `texels` has any other length than `width * height` or a length of more
    /// than `u32::MAX`, or a cube's picture is not six times as high as wide.
    pub fn new(mapping: Mapping, width: usize, height: usize, texels: Vec<Rgb<f32>>) -> Result<Self, EnvError> {
        Self::check(mapping, width, height)?;
        if width.checked_mul(height) != Some(texels.len()) {
            let found = texels.len();
            return Err(EnvError::Options(format!("{width} x {height} texels expected, {found} given")));
        }
        Ok(Self { mapping, width, height, texels })
    }

    /// The map whose texels have the value of `radiance` towards their centers; of a texel whose center lies outside
    /// the discs, towards the middle of the part inside.
    ///
    /// # Panics
    /// If a side is 0, or a cube's picture is not six times as high as wide.
    #[must_use]
    pub fn from_fn(mapping: Mapping, width: usize, height: usize, radiance: impl Fn(Dir) -> Rgb<f32> + Sync) -> Self {
        Self::filled(mapping, width, height, &radiance)
    }

    /// [`from_fn`](Self::from_fn), compiled once and not for each function.
    fn filled(mapping: Mapping, width: usize, height: usize, radiance: &(dyn Fn(Dir) -> Rgb<f32> + Sync)) -> Self {
        if let Err(error) = Self::check(mapping, width, height) {
            panic!("{error}");
        }
        let mut texels = vec![Rgb::ZERO; width * height];
        parallel::rows(&mut texels, width, &|y, row| {
            for (x, texel) in row.iter_mut().enumerate() {
                if let Some(s) = center(mapping, width, height, x, y) {
                    *texel = radiance(s);
                }
            }
        });
        Self { mapping, width, height, texels }
    }

    /// Fails if there can be no picture of this size.
    pub(crate) fn check(mapping: Mapping, width: usize, height: usize) -> Result<(), EnvError> {
        if width == 0 || height == 0 {
            return Err(EnvError::Options(format!("an environment map needs texels, but {width} x {height} has none")));
        }
        let faces = mapping.faces();
        if faces > 1 && width.checked_mul(faces) != Some(height) {
            let message = format!("a cube's picture is six times as high as wide, but {width} x {height} is not");
            return Err(EnvError::Options(message));
        }
        if width.checked_mul(height).is_none_or(|texels| texels > MOST_TEXELS) {
            let message = format!("a map has at most {MOST_TEXELS} texels, and {width} x {height} are more");
            return Err(EnvError::Options(message));
        }
        Ok(())
    }

    /// A map of texels whose number was checked.
    pub(crate) fn from_rows(mapping: Mapping, width: usize, height: usize, texels: Vec<Rgb<f32>>) -> Self {
        debug_assert!(width * height == texels.len() && !texels.is_empty(), "{width} x {height}: {}", texels.len());
        Self { mapping, width, height, texels }
    }

    /// The mapping of the picture.
    #[must_use]
    pub fn mapping(&self) -> Mapping {
        self.mapping
    }

    /// The name of the mapping where a reader of the picture would take it for another by its proportions; none for lat-long
    /// twice as wide as high, and for a cube.
    #[must_use]
    pub fn untold_mapping(&self) -> Option<&'static str> {
        let is_told = self.mapping.form().is_told_by([self.width, self.height]);
        (!is_told).then(|| self.mapping.name())
    }

    /// The number of columns, at least 1.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// The number of rows, at least 1.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// All texels, row after row from the top.
    #[must_use]
    pub fn texels(&self) -> &[Rgb<f32>] {
        &self.texels
    }

    /// All texels, to change.
    #[must_use]
    pub fn texels_mut(&mut self) -> &mut [Rgb<f32>] {
        &mut self.texels
    }

    /// All texels, as a vector.
    #[must_use]
    pub fn into_texels(self) -> Vec<Rgb<f32>> {
        self.texels
    }

    /// The texels of row `y`.
    ///
    /// # Panics
    /// If `y >= height`.
    #[must_use]
    pub fn row(&self, y: usize) -> &[Rgb<f32>] {
        &self.texels[y * self.width..][..self.width]
    }

    /// The texel in column `x` of row `y`.
    ///
    /// # Panics
    /// If there is no such texel.
    #[must_use]
    pub fn texel(&self, x: usize, y: usize) -> Rgb<f32> {
        assert!(x < self.width, "no column {x} in a map of {}", self.width);
        self.row(y)[x]
    }

    /// The direction of the center of texel `(x, y)`; if that lies outside the discs, of the middle of the part inside;
    /// `None` if the whole texel lies outside.
    #[must_use]
    pub fn dir(&self, x: usize, y: usize) -> Option<Dir> {
        center(self.mapping, self.width, self.height, x, y)
    }

    /// The column and the row of the texel that contains the direction `s`.
    #[must_use]
    pub fn texel_at(&self, s: Dir) -> (usize, usize) {
        let grid = self.grid();
        let index = grid.texel(grid.point(s));
        (index % self.width, index / self.width)
    }

    /// The exact solid angle of texel `(x, y)`.
    ///
    /// # Panics
    /// If there is no such texel.
    #[must_use]
    pub fn solid_angle(&self, x: usize, y: usize) -> f64 {
        self.mapping.solid_angle(self.width, self.height, x, y)
    }

    /// The radiance from direction `s`, interpolated bilinearly between texel centers and across every seam.
    ///
    /// Beyond an edge the map continues with the texels that are neighbors on the sphere: around the seam of the
    /// lat-long picture, across its poles, along the folds of the octahedron, from face to face of a cube and from rim
    /// to rim of the discs. So the value is continuous, except at the poles of the lat-long picture and in the one
    /// direction of the rim of a ball or an angular map, and there along every great circle (test
    /// `the_radiance_of_every_mapping_is_continuous_across_its_seams`).
    #[must_use]
    pub fn radiance(&self, s: Dir) -> Rgb<f32> {
        let grid = self.grid();
        let taps = grid.taps_towards(s);
        taps.iter().fold(Rgb::ZERO, |sum, (index, weight)| sum + self.texels[index].scale(weight))
    }

    /// The mean over the sphere, every texel weighted with its solid angle.
    #[must_use]
    pub fn mean(&self) -> Rgb<f64> {
        let solid_angles = SolidAngles::new(self.grid());
        let rows: Vec<Rgb<f64>> = parallel::map(self.height, &|y| {
            let mut sum: Rgb<f64> = Rgb::ZERO;
            for (x, texel) in self.row(y).iter().enumerate() {
                let solid_angle = solid_angles.get(x, y);
                // Texels outside the discs may hold any value.
                if solid_angle > 0.0 {
                    sum += texel.widen().scale(solid_angle);
                }
            }
            sum
        });
        rows.into_iter().fold(Rgb::ZERO, |sum, row| sum + row).scale(0.25 * std::f64::consts::FRAC_1_PI)
    }

    /// The share of the light of the sphere that channels have above `most`, 0 to 1: what a format loses whose numbers
    /// end there.
    #[must_use]
    pub fn share_beyond(&self, most: f32) -> f64 {
        let solid_angles = SolidAngles::new(self.grid());
        let rows: Vec<[f64; 2]> = parallel::map(self.height, &|y| {
            let mut sums = [0.0; 2];
            for (x, texel) in self.row(y).iter().enumerate() {
                let solid_angle = solid_angles.get(x, y);
                for channel in texel.to_array().into_iter().filter(|c| *c > 0.0 && c.is_finite() && solid_angle > 0.0) {
                    sums[0] += solid_angle * f64::from(channel);
                    sums[1] += solid_angle * f64::from(channel - channel.min(most));
                }
            }
            sums
        });
        let [all, beyond] = rows.into_iter().fold([0.0; 2], |[all, beyond], row| [all + row[0], beyond + row[1]]);
        if beyond > 0.0 { beyond / all } else { 0.0 }
    }

    /// The shape of the picture.
    pub(crate) fn grid(&self) -> Grid {
        Grid::new(self.mapping, self.width, self.height)
    }

    /// Refuses a map of another mapping.
    pub(crate) fn expect(&self, mapping: Mapping) -> Result<(), EnvError> {
        if self.mapping == mapping {
            return Ok(());
        }
        Err(EnvError::Options(format!("a {mapping} map expected, found a map that is {}: convert it", self.mapping)))
    }
}

impl<'a> From<&'a MappedMap> for Cow<'a, MappedMap> {
    fn from(map: &'a MappedMap) -> Self {
        Self::Borrowed(map)
    }
}

impl From<MappedMap> for Cow<'_, MappedMap> {
    fn from(map: MappedMap) -> Self {
        Self::Owned(map)
    }
}

/// Conversions of a map of one mapping from and to the [`MappedMap`] that it wraps, by reference and by value.
macro_rules! of_one_mapping {
    ($map:ty) => {
        impl $map {
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
        }

        impl std::ops::Deref for $map {
            type Target = MappedMap;

            fn deref(&self) -> &MappedMap {
                &self.0
            }
        }

        impl From<$map> for MappedMap {
            fn from(map: $map) -> Self {
                map.0
            }
        }

        impl<'a> From<&'a $map> for std::borrow::Cow<'a, MappedMap> {
            fn from(map: &'a $map) -> Self {
                Self::Borrowed(map)
            }
        }

        impl From<$map> for std::borrow::Cow<'_, MappedMap> {
            fn from(map: $map) -> Self {
                Self::Owned(map.0)
            }
        }
    };
}

pub(crate) use of_one_mapping;

/// The direction of the center of a texel, or of the middle of its part inside the discs.
fn center(mapping: Mapping, width: usize, height: usize, x: usize, y: usize) -> Option<Dir> {
    let (u, v) = ((x as f64 + 0.5) / width as f64, (y as f64 + 0.5) / height as f64);
    mapping.dir_from_uv(u, v).or_else(|| {
        let mut nodes = Vec::new();
        let rule = lobe_sh::sphere::gauss_legendre(2);
        crate::mapping::texel_quadrature::nodes_into(mapping, [width, height], [x, y], &rule, &mut nodes);
        let sum = nodes.iter().fold([0.0; 3], |sum, (s, weight)| {
            let s = s.to_array();
            [0, 1, 2].map(|k| sum[k] + weight * s[k])
        });
        Dir::new(sum)
    })
}
