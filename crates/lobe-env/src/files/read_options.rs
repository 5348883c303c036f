//! Options and report of the map readers.

use lobe_image::{FileFormat, Nonfinite, PictureReadOptions, PictureReadReport};

use crate::{CubeHandedness, CubeLayout, EnvError, MapReadOption, Mapping};

/// Options of reading an environment map.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MapReadOptions {
    /// The treatment of NaN and infinity; by default the file is refused.
    pub nonfinite: Nonfinite,
    /// The largest picture, in texels, for which memory is asked for; by default 2²⁸, enough for 16384 x 8192.
    pub max_texels: usize,
    /// The mapping of the picture, for [`read_map`](crate::read_map); by default the file or its proportions determine
    /// it.
    pub mapping: Option<Mapping>,
    /// The handedness for which the faces of a cube were made, for [`read_map`](crate::read_map); by default right.
    pub handedness: CubeHandedness,
}

impl Default for MapReadOptions {
    fn default() -> Self {
        let PictureReadOptions { nonfinite, max_texels, .. } = PictureReadOptions::default();
        Self { nonfinite, max_texels, mapping: None, handedness: CubeHandedness::default() }
    }
}

impl MapReadOptions {
    /// Sets the treatment of NaN and infinity.
    #[must_use]
    pub fn nonfinite(self, nonfinite: Nonfinite) -> Self {
        Self { nonfinite, ..self }
    }

    /// Sets the largest picture, in texels.
    #[must_use]
    pub fn max_texels(self, max_texels: usize) -> Self {
        Self { max_texels, ..self }
    }

    /// Sets the mapping of the picture.
    #[must_use]
    pub fn mapping(self, mapping: impl Into<Option<Mapping>>) -> Self {
        Self { mapping: mapping.into(), ..self }
    }

    /// Sets the handedness for which the faces of a cube were made.
    #[must_use]
    pub fn handedness(self, handedness: CubeHandedness) -> Self {
        Self { handedness, ..self }
    }

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

    /// The same for a picture of any shape.
    pub(crate) fn of_picture(&self) -> PictureReadOptions {
        PictureReadOptions::default().nonfinite(self.nonfinite).max_texels(self.max_texels)
    }
}

/// The report of reading a map.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MapReadReport {
    /// Columns; of a cube map, those of a face.
    pub width: usize,
    /// Rows; of a cube map, those of a face.
    pub height: usize,
    /// Levels of a cube map; 1 for a picture.
    pub levels: usize,
    /// The kind of file.
    pub format: FileFormat,
    /// Texels with a NaN or infinite channel; they are black in the map.
    pub nonfinite: usize,
    /// Column and row of the first of them; in a cube map, of the faces of its level one above another.
    pub first_nonfinite: Option<(usize, usize)>,
    /// Texels with a negative channel; they are kept.
    pub negative: usize,
    /// Remarks for the caller: channels chosen, parts of the file ignored, factors applied.
    pub notes: Vec<String>,
    /// The layout of a cube's faces in the picture, where it follows from the proportions.
    pub layout: Option<CubeLayout>,
    /// The reports of the six files of a cube; otherwise none.
    pub faces: Vec<Self>,
    /// Whether the centers of the outer texels lie on the edges of the picture in the file, or of the faces of its
    /// cube.
    pub(crate) is_edge_centered: bool,
}

impl From<PictureReadReport> for MapReadReport {
    /// The report of a picture whose attribute `envmap` is ignored.
    fn from(report: PictureReadReport) -> Self {
        let PictureReadReport { width, height, levels, format, nonfinite, first_nonfinite, negative, notes, .. } =
            report;
        let (layout, faces, is_edge_centered) = (None, Vec::new(), false);
        Self {
            width,
            height,
            levels,
            format,
            nonfinite,
            first_nonfinite,
            negative,
            notes,
            layout,
            faces,
            is_edge_centered,
        }
    }
}

impl MapReadReport {
    /// The report of a picture whose attribute `envmap` is honored.
    pub(crate) fn of_map(report: PictureReadReport) -> Self {
        let is_edge_centered = report.envmap.is_some();
        let mut report = Self { is_edge_centered, ..report.into() };
        if is_edge_centered {
            let note = "by the attribute envmap the outer texels lie on the edges; the map is interpolated";
            report.notes.push(note.into());
        }
        report
    }
}
