//! Options and report of the map reader.

use std::fmt;

use derive_setters::Setters;
use lobe_image::{Nonfinite, PictureReadOptions, PictureReadReport};

use crate::error::{EnvError, MapReadOption};
use crate::files::cropped::Padding;
use crate::files::fisheye::FisheyeOptions;
use crate::map::cube_handedness::CubeHandedness;
use crate::map::cube_layout::CubeLayout;
use crate::map::face_order::FaceOrder;
use crate::mapping::mapping::Mapping;

/// Options of reading an environment map.
///
/// ```
/// use lobe_env::{MapReadOptions, Mapping, Padding};
///
/// // A cropped panorama of 60 degrees in height.
/// let options = MapReadOptions::default().elevations([-0.52, 0.52]).padding(Padding::Edge).max_texels(1 << 20);
/// assert_eq!(options.picture.max_texels, 1 << 20);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct MapReadOptions {
    /// The limits of every picture that is read, and of the map that is made of it; of six files together.
    pub picture: PictureReadOptions,
    /// The mapping of the picture; by default the file or its proportions determine it.
    #[setters(into)]
    pub mapping: Option<Mapping>,
    /// The lowest and the highest elevation that the rows of a lat-long picture show, in radians; by default -π/2 and π/2.
    /// The map is that of the whole sphere, and `mapping` lat-long.
    #[setters(into)]
    pub elevations: Option<[f64; 2]>,
    /// How a fisheye picture shows its surroundings; by default it is none. The map is lat-long, of the whole sphere, and
    /// `mapping` and `elevations` are at their defaults.
    #[setters(into)]
    pub fisheye: Option<FisheyeOptions>,
    /// What the directions get that a cropped panorama or a fisheye picture does not show; black by default.
    pub padding: Padding,
    /// The handedness for which the faces of a cube were made; by default what the file says, else right. Files that
    /// are named by sides are then no photographs, unless `faces` says so.
    #[setters(into)]
    pub handedness: Option<CubeHandedness>,
    /// The faces of a cube in their order in the picture, the texture or the numbered files; names of sides say that
    /// they are photographs. Of files that are named by sides, the names tell which is which. By default the file or
    /// its name tells it, else they are +X to -Z.
    #[setters(into)]
    pub faces: Option<FaceOrder>,
}

impl MapReadOptions {
    /// The options with another limit of texels, see [`PictureReadOptions::max_texels`].
    #[must_use]
    pub fn max_texels(mut self, max_texels: usize) -> Self {
        self.picture.max_texels = max_texels;
        self
    }

    /// The options with another treatment of NaN and infinity, see [`PictureReadOptions::nonfinite`].
    #[must_use]
    pub fn nonfinite(mut self, nonfinite: Nonfinite) -> Self {
        self.picture.nonfinite = nonfinite;
        self
    }

    /// The mapping that was asked for; only lat-long pictures have elevations, and fisheye pictures become lat-long.
    pub(crate) fn asked(&self) -> Option<Mapping> {
        let is_lat_long = self.elevations.is_some() || self.fisheye.is_some();
        let asked = self.mapping.or(is_lat_long.then_some(Mapping::LatLong));
        asked.or(self.faces.is_some().then_some(Mapping::Cube))
    }

    /// Whether nothing is said of the faces of a cube.
    pub(crate) fn leaves_faces_open(&self) -> bool {
        self.faces.is_none() && self.handedness.is_none()
    }

    /// The handedness of faces where the file says none.
    pub(crate) fn hand(&self) -> CubeHandedness {
        self.handedness.unwrap_or_default()
    }

    /// Refuses to take a picture for a fisheye and for something else.
    pub(crate) fn check_fisheye(&self, name: &str) -> Result<(), EnvError> {
        if self.fisheye.is_none() || (self.mapping.is_none() && self.elevations.is_none()) {
            return Ok(());
        }
        let message =
            format!("{name}: a fisheye picture has no other mapping and no elevations; leave them at their defaults");
        Err(EnvError::Options(message))
    }

    /// The options for a file that names this mapping: the faces of its cube may be left-handed. That is noted, and so
    /// is an option that says something else, which holds.
    pub(crate) fn for_file(&self, mapping: Option<&str>, notes: &mut Vec<String>) -> Self {
        let is_cube = self.asked().is_none_or(|mapping| mapping == Mapping::Cube);
        if !is_cube || !CubeHandedness::is_left(mapping) {
            return self.clone();
        }
        if self.handedness == Some(CubeHandedness::Right) {
            notes.push(
                "the file says that the faces of the cube are left-handed; they are taken for right-handed".into(),
            );
            return self.clone();
        }
        notes.push("the faces of the cube are left-handed, as the file says".to_owned());
        self.clone().handedness(CubeHandedness::Left)
    }

    /// Refuses another requested mapping than that of the file, which is called `found`.
    pub(crate) fn expect(&self, mapping: Mapping, name: &str, found: &str) -> Result<(), EnvError> {
        let option = match self.mapping {
            Some(asked) if asked != mapping => MapReadOption::Mapping,
            _ if self.elevations.is_some() && mapping != Mapping::LatLong => MapReadOption::Elevations,
            _ if self.fisheye.is_some() && mapping != Mapping::LatLong => MapReadOption::Fisheye,
            _ if self.faces.is_some() && mapping != Mapping::Cube => MapReadOption::Faces,
            _ => return Ok(()),
        };
        Err(EnvError::Contradiction { place: name.into(), found: found.into(), option })
    }

    /// Refuses to take for a fisheye picture what is known to be a map, which is called `found`.
    pub(crate) fn expect_no_fisheye(&self, name: &str, found: &str) -> Result<(), EnvError> {
        if self.fisheye.is_none() {
            return Ok(());
        }
        let option = MapReadOption::Fisheye;
        Err(EnvError::Contradiction { place: name.into(), found: found.into(), option })
    }

    /// Refuses a handedness for anything but a cube.
    pub(crate) fn check_handedness(&self, mapping: Mapping, name: &str) -> Result<(), EnvError> {
        if mapping == Mapping::Cube || self.handedness.is_none() {
            return Ok(());
        }
        let option = MapReadOption::Handedness;
        Err(EnvError::Contradiction { place: name.into(), found: mapping.to_string(), option })
    }
}

/// The report of reading a map.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct MapReadReport {
    /// The report of the picture; of the first one if there are six.
    pub picture: PictureReadReport,
    /// The layout of a cube's faces in the picture, where it follows from the proportions.
    pub layout: Option<CubeLayout>,
    /// The reports of the six files of a cube; otherwise none.
    pub faces: Vec<PictureReadReport>,
    /// What the file itself says of the map and decides how it is read, as remarks: its mapping, the hand of a cube's faces.
    pub told: Vec<String>,
    /// What was assumed of the faces of a cube where neither the file nor the options say it; none of a texture.
    pub assumed: Option<FaceAssumption>,
}

/// An assumption on what the faces of a cube show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub enum FaceAssumption {
    /// They are +X, -X, +Y, -Y, +Z, -Z in this order, made for right-handed directions.
    RightHanded,
    /// They are photographs, as their names are those of sides; the front is the middle of the panorama.
    Photographs,
}

impl fmt::Display for FaceAssumption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::RightHanded => "the faces are taken for +X, -X, +Y, -Y, +Z, -Z of right-handed directions",
            Self::Photographs => "the faces are taken for photographs, the front in the middle of the panorama",
        })
    }
}

impl From<PictureReadReport> for MapReadReport {
    fn from(picture: PictureReadReport) -> Self {
        Self { picture, layout: None, faces: Vec::new(), told: Vec::new(), assumed: None }
    }
}
