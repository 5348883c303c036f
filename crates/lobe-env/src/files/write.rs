//! Writers of lat-long maps.

use std::path::Path;

use lobe_image::{PictureWriteOptions, PictureWriteReport, encode_picture};
use lobe_io::write_atomically;

use crate::{EnvError, EnvMap};

/// Options of writing an environment map.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct MapWriteOptions {
    /// Store OpenEXR as 16-bit `half` instead of 32-bit `float`: half the size, three digits, at most 65504.
    pub half: bool,
}

impl MapWriteOptions {
    /// Sets whether OpenEXR is stored as `half`.
    #[must_use]
    pub fn half(self, half: bool) -> Self {
        Self { half }
    }

    fn of_picture(&self) -> PictureWriteOptions {
        PictureWriteOptions::default().half(self.half)
    }
}

/// The loss of writing a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MapWriteReport {
    /// Texels with a channel outside the range of the format, which was clamped to it; NaN in `.hdr` becomes 0.
    pub clamped: usize,
}

impl From<PictureWriteReport> for MapWriteReport {
    fn from(PictureWriteReport { clamped, .. }: PictureWriteReport) -> Self {
        Self { clamped }
    }
}

/// Writes a map as Radiance `.hdr`, OpenEXR `.exr` (ZIP) or portable float map `.pfm`, depending on the extension.
///
/// The file is written under a temporary name in the same folder and then renamed: no partial file ever has the final
/// name. `.hdr` holds no negative numbers and two digits (the error of a channel is below 0.4 % of the largest channel
/// of its texel, of either sign); `.exr` and `.pfm` hold `f32` exactly.
///
/// # Errors
/// [`EnvError::Options`] for another extension, or a map too wide for `.hdr`; [`EnvError::Io`] if the file cannot be
/// written.
pub fn write_env(path: impl AsRef<Path>, map: &EnvMap, options: &MapWriteOptions) -> Result<MapWriteReport, EnvError> {
    let path = path.as_ref();
    let (bytes, report) = encode(path, map, options)?;
    let io = |source| EnvError::Io { place: path.display().to_string(), source };
    write_atomically(path, |file| file.write_all(&bytes)).map_err(io)?;
    Ok(report)
}

/// The bytes of the file that [`write_env`] writes.
pub(crate) fn encode(
    path: &Path,
    map: &EnvMap,
    options: &MapWriteOptions,
) -> Result<(Vec<u8>, MapWriteReport), EnvError> {
    let (bytes, report) = encode_picture(path, map.width(), map.texels(), &options.of_picture())?;
    Ok((bytes, report.into()))
}
