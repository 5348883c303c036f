//! Options and report of the map reader.

use derive_setters::Setters;
use lobe_image::{PictureReadOptions, PictureReadReport};

use crate::{CubeHandedness, CubeLayout, EnvError, MapReadOption, Mapping};

/// Options of reading an environment map.
#[derive(Clone, Debug, Default, PartialEq, Eq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct MapReadOptions {
    /// The limits of every picture that is read.
    pub picture: PictureReadOptions,
    /// The mapping of the picture; by default the file or its proportions determine it.
    #[setters(into)]
    pub mapping: Option<Mapping>,
    /// The handedness for which the faces of a cube were made; by default right.
    pub handedness: CubeHandedness,
}

impl MapReadOptions {
    /// Refuses another requested mapping than that of the file, which is called `found`.
    pub(crate) fn expect(&self, mapping: Mapping, name: &str, found: &str) -> Result<(), EnvError> {
        if self.mapping.is_none_or(|asked| asked == mapping) {
            return Ok(());
        }
        let option = MapReadOption::Mapping;
        Err(EnvError::Contradiction { place: name.into(), found: found.into(), option })
    }

    /// Refuses a handedness for anything but a cube.
    pub(crate) fn check_handedness(&self, mapping: Mapping, name: &str) -> Result<(), EnvError> {
        if mapping == Mapping::Cube || self.handedness == CubeHandedness::default() {
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
}

impl From<PictureReadReport> for MapReadReport {
    fn from(picture: PictureReadReport) -> Self {
        Self { picture, layout: None, faces: Vec::new() }
    }
}
