//! Fisheye pictures: a round picture of a part of the sphere, or of all of it, as a map.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use derive_setters::Setters;
use lobe_image::{Picture, PictureReadOptions};
use lobe_io::Job;
use lobe_sh::sphere::vector::cross;
use lobe_sh::{Dir, Rotation};

use crate::error::EnvError;
use crate::files::cropped::Padding;
use crate::files::fisheye_rays::RoundPicture;
use crate::map::env_map::EnvMap;
use crate::map::finite::expect_finite;
use crate::map::mapped_map::MappedMap;
use crate::mapping::fisheye::FisheyeProjection;
use crate::mapping::fisheye::{Lens, rounded_degrees};
use crate::mapping::mapping::Mapping;
use crate::resample::resample::{Resample, resample};

/// How a fisheye picture shows its surroundings.
///
/// The picture is a photograph: not mirrored, seen from inside. The top of the picture points to the direction nearest to +z,
/// if the lens looked less than 45° up or down, and else to the one nearest to +x, the middle of the lat-long picture. So a
/// picture of the sky, `axis` +z, has +x at the top and +y on its right, and one of the ground, `axis` -z, has +x at the top
/// and -y on its right: with +x as north, west is on the right of the sky, and east on the right of the ground.
///
/// ```
/// use lobe_env::{FisheyeOptions, FisheyeProjection, MapReadOptions, Padding};
///
/// // A photograph of the sky of 3000 x 2000 pixels, whose circle is not quite in the middle.
/// let lens = FisheyeOptions::default().projection(FisheyeProjection::Equisolid).circle([1512.0, 993.0, 930.0]);
/// let options = MapReadOptions::default().fisheye(lens).padding(Padding::Edge);
/// # assert_eq!(options.fisheye.map(|lens| lens.field_of_view), Some(std::f64::consts::PI));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct FisheyeOptions {
    /// How the lens shows the angle to its axis; equidistant by default.
    pub projection: FisheyeProjection,
    /// The full angle across the circle, in radians; π by default. The projection has a limit:
    /// [`FisheyeProjection::check_field_of_view`].
    pub field_of_view: f64,
    /// The direction in which the lens looked, which is in the middle of the circle; +z, up, by default.
    pub axis: Dir,
    /// Column and row of the middle of the circle, and its radius, in pixels from the upper left corner of the picture; by
    /// default the largest circle about the middle of the picture. It may reach beyond the picture, its middle not.
    #[setters(into)]
    pub circle: Option<[f64; 3]>,
}

impl Default for FisheyeOptions {
    fn default() -> Self {
        Self { projection: FisheyeProjection::default(), field_of_view: PI, axis: Dir::Z, circle: None }
    }
}

impl FisheyeOptions {
    /// A remark on what the picture shows of a map.
    pub(crate) fn remark(&self, map: &EnvMap) -> String {
        let degrees = rounded_degrees(self.field_of_view);
        let [x, y, z] = self.axis.to_array().map(|c| c + 0.0);
        let (width, height) = (map.width(), map.height());
        let lens = self.projection;
        format!("it shows {degrees}° around {x:.3},{y:.3},{z:.3} ({lens} fisheye) of a map of {width} x {height}")
    }

    /// Column and row of the middle of the circle, and its radius.
    fn circle_in(&self, [width, height]: [usize; 2]) -> Result<[f64; 3], EnvError> {
        let (w, h) = (width as f64, height as f64);
        let circle = self.circle.unwrap_or([0.5 * w, 0.5 * h, 0.5 * w.min(h)]);
        let [x, y, radius] = circle;
        if x > 0.0 && x < w && y > 0.0 && y < h && radius > 0.0 && radius.is_finite() {
            return Ok(circle);
        }
        let message = format!(
            "the circle of a fisheye picture of {width} x {height} pixels has its middle in it and a radius above 0, and \
             {x},{y},{radius} has not"
        );
        Err(EnvError::Options(message))
    }

    /// The rotation that takes +z to the axis and +x to where the top of the picture points; `None` for a picture of the
    /// sky, which needs none. Refuses an axis that is no unit vector.
    fn rotation(&self) -> Result<Option<Rotation>, EnvError> {
        if self.axis == Dir::Z {
            return Ok(None);
        }
        let axis = self.axis.to_array();
        // The direction in the plane of the picture that is nearest to the one wanted.
        let wanted = if axis[2].abs() > FRAC_1_SQRT_2 { Dir::X } else { Dir::Z };
        let (along, wanted) = (self.axis.dot(wanted), wanted.to_array());
        let refused = |why: String| EnvError::Options(format!("the axis {axis:?} of a fisheye picture: {why}"));
        let top = Dir::new([0, 1, 2].map(|k| wanted[k] - along * axis[k]));
        let top = top.ok_or_else(|| refused("expected a unit vector".into()))?.to_array();
        let right = cross(axis, top);
        let rotation = Rotation::from_matrix([0, 1, 2].map(|k| [top[k], right[k], axis[k]]));
        rotation.map(Some).map_err(|error| refused(error.to_string()))
    }
}

/// The lat-long map of a fisheye picture.
///
/// About as many texels lie in the circle as there are pixels. Lat-long, because a circle of 180° around the zenith so ends
/// between two rows and black below does not darken the horizon, and as most programs read no other map. Pixels are
/// integrated along rays ([`fisheye_rays`](crate::files::fisheye_rays)), so that the light of the circle, each pixel by its
/// solid angle, is that of the map (test `the_light_of_skies_is_that_of_their_closed_forms`). The axis +z, and -z too, needs
/// no interpolation; for others the map is turned by [`resample`](crate::resample()).
pub(crate) fn fisheye_map(
    picture: Picture,
    fisheye: &FisheyeOptions,
    padding: Padding,
    limits: &PictureReadOptions,
    place: &str,
) -> Result<EnvMap, EnvError> {
    let named = |error: EnvError| EnvError::Options(format!("{place}: {error}"));
    let size = [picture.width(), picture.height()];
    let lens = Lens::new(fisheye.projection, fisheye.field_of_view).map_err(named)?;
    let [x, y, radius] = fisheye.circle_in(size).map_err(named)?;
    let rows = RoundPicture::rows(&lens, radius);
    limits.check_made([(2.0 * rows) as usize, rows as usize], place)?;
    let round = RoundPicture { lens, size, middle: [x, y], radius, pixels: picture.into_pixels() };
    let map = round.to_lat_long(rows as usize, padding);
    // A pixel that is alone among dark ones is brightened by what the rays miss.
    expect_finite(map.texels(), "the light of the fisheye picture", || true).map_err(named)?;
    let Some(rotation) = fisheye.rotation().map_err(named)? else { return Ok(map) };
    let to = Resample::to(Mapping::LatLong, map.width(), map.height()).rotated(rotation);
    resample(MappedMap::from(map), &to, Job::default()).map_err(named)?.into_env_map()
}
