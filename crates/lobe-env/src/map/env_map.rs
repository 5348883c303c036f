//! Lat-long environment maps.

use lobe_image::Picture;
use lobe_sh::{Dir, Rgb};

use crate::error::EnvError;
use crate::map::mapped_map::MappedMap;
use crate::map::mapped_map::of_one_mapping;
use crate::mapping::lat_long;
use crate::mapping::mapping::Mapping;

/// The radiance that arrives at a point from every direction, as a lat-long picture.
///
/// Row 0 is at the top, towards +z; the center column looks along +x; see [`lat_long`]. Linear light, Rec. 709
/// primaries unless the file it came from says otherwise. The width is usually twice the height, but need not be. It is a
/// [`MappedMap`], and lends itself as one: size, texels, the radiance from a direction, the mean.
///
/// Texels may be negative, as overshoot beside a small light in a real file is. They should be finite, as the readers
/// ensure: sums over a map with a single NaN or infinity are NaN or infinite too.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvMap(MappedMap);

impl EnvMap {
    /// A map from its texels, row after row.
    ///
    /// # Errors
    /// [`EnvError::Options`] if a side is 0 or `texels` has any other length than `width * height`.
    pub fn new(width: usize, height: usize, texels: Vec<Rgb<f32>>) -> Result<Self, EnvError> {
        MappedMap::new(Mapping::LatLong, width, height, texels).map(Self)
    }

    /// The map whose texels have the value of `radiance` towards their centers.
    ///
    /// # Panics
    /// If a side is 0.
    #[must_use]
    pub fn from_fn(width: usize, height: usize, radiance: impl Fn(Dir) -> Rgb<f32> + Sync) -> Self {
        Self(MappedMap::from_fn(Mapping::LatLong, width, height, radiance))
    }

    /// A map from as many texels as it needs.
    pub(crate) fn from_rows(width: usize, height: usize, texels: Vec<Rgb<f32>>) -> Self {
        Self(MappedMap::from_rows(Mapping::LatLong, width, height, texels))
    }

    /// The direction of the center of texel `(x, y)`.
    #[must_use]
    pub fn dir(&self, x: usize, y: usize) -> Dir {
        lat_long::dir_from_uv((x as f64 + 0.5) / self.width() as f64, (y as f64 + 0.5) / self.height() as f64)
    }
}

of_one_mapping!(EnvMap);

impl MappedMap {
    /// The lat-long map of the same texels.
    ///
    /// # Errors
    /// [`EnvError::Options`] if the mapping is another.
    pub fn into_env_map(self) -> Result<EnvMap, EnvError> {
        self.expect(Mapping::LatLong)?;
        Ok(EnvMap(self))
    }
}

impl From<&EnvMap> for Picture {
    /// The lat-long picture, texel by texel.
    ///
    /// ```
    /// use lobe_env::bundled;
    /// use lobe_image::{Picture, Tone};
    ///
    /// let sky = Picture::from(&bundled::sunset().map());
    /// let png = sky.resized(256, 128).to_png(&Tone::PHOTOGRAPH)?;
    /// # assert_eq!(&png[1..4], b"PNG");
    /// # Ok::<(), lobe_image::ImageError>(())
    /// ```
    fn from(map: &EnvMap) -> Self {
        Self::from_fn(map.width(), map.height(), |x, y| map.texel(x, y))
    }
}

#[cfg(test)]
mod tests {
    use lobe_sh::Coefficient;
    use lobe_testkit::{Random, directions};

    use super::*;

    fn numbered(width: usize, height: usize) -> EnvMap {
        let mut random = Random::new(7);
        let texels = (0..width * height).map(|i| Rgb::new(i as f32, random.unit() as f32, 1.0)).collect();
        EnvMap::new(width, height, texels).unwrap()
    }

    #[test]
    fn a_map_without_texels_or_with_too_few_is_refused() {
        for (w, h, n) in [(0, 0, 0), (0, 4, 0), (4, 0, 0), (4, 2, 7), (usize::MAX, 2, 4)] {
            let error = EnvMap::new(w, h, vec![Rgb::ZERO; n]);
            assert!(matches!(error, Err(EnvError::Options(_))), "{w} x {h} with {n} texels: {error:?}");
        }
    }

    #[test]
    fn at_texel_centers_the_radiance_is_the_texel() {
        for (w, h) in [(2, 1), (4, 2), (7, 5), (64, 32)] {
            let map = numbered(w, h);
            for y in 0..h {
                for x in 0..w {
                    let (found, texel) = (map.radiance(map.dir(x, y)), map.texel(x, y));
                    let error = (found.g - texel.g).abs().max((found.r - texel.r).abs() / (w * h) as f32);
                    assert!(error < 1e-5, "{w} x {h} at ({x}, {y}): {found:?} against {texel:?}");
                }
            }
        }
    }

    #[test]
    fn a_constant_map_is_constant_in_every_direction() {
        for (w, h) in [(1, 1), (2, 1), (3, 2), (8, 4)] {
            let map = EnvMap::from_fn(w, h, |_| Rgb::new(1.0, 2.0, 3.0));
            for v in directions() {
                let found = map.radiance(Dir::new(v).unwrap());
                assert!((found.b - 3.0).abs() < 1e-6, "{w} x {h} towards {v:?}: {found:?}");
            }
        }
    }

    #[test]
    fn the_radiance_is_continuous_across_the_seam_and_across_the_poles() {
        let small = 1e-7;
        for (w, h) in [(8, 4), (7, 5), (2, 1), (1, 1)] {
            let map = numbered(w, h);
            let step = |a: Dir, b: Dir, place: &str| {
                let (a, b) = (map.radiance(a), map.radiance(b));
                assert!((a.g - b.g).abs() < 1e-4, "{place} of {w} x {h}: {a:?} and {b:?}");
            };
            for k in 0..50 {
                let theta = 0.02 + 3.1 * f64::from(k) / 50.0;
                let phi = std::f64::consts::PI;
                step(Dir::from_angles(theta, phi - small), Dir::from_angles(theta, small - phi), "seam");
                let across = |theta: f64| {
                    let phi = 0.13 * f64::from(k);
                    (Dir::from_angles(theta, phi), Dir::from_angles(theta, phi + std::f64::consts::PI))
                };
                let (a, b) = across(small);
                step(a, b, "upper pole");
                let (a, b) = across(std::f64::consts::PI - small);
                step(a, b, "lower pole");
            }
        }
    }

    #[test]
    fn from_fn_looks_towards_the_texel_centers() {
        let map = EnvMap::from_fn(64, 32, |s| Rgb::new(s.x() as f32, s.y() as f32, s.z() as f32));
        assert!(map.texel(32, 0).b > 0.99, "the top row is +z: {:?}", map.texel(32, 0));
        assert!(map.texel(32, 16).r > 0.99, "the center is +x: {:?}", map.texel(32, 16));
        assert!(map.texel(48, 16).g < -0.99, "right of the center is -y: {:?}", map.texel(48, 16));
    }

    #[test]
    fn the_mean_of_a_constant_map_is_the_constant() {
        let mean = EnvMap::from_fn(9, 5, |_| Rgb::new(0.25, 1.0, 4.0)).mean();
        assert!((mean.b - 4.0).abs() < 1e-14 && (mean.r - 0.25).abs() < 1e-15, "{mean:?}");
    }
}
