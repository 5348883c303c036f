//! Writers of maps.

use derive_setters::Setters;
use std::path::Path;

use lobe_image::{
    ImageError, PictureWriteOptions, PictureWriteReport, TexelFormat, encode_picture, write_cube_texture,
};
use lobe_io::write_atomically;

use crate::{CubeMipChain, MappedMap};

/// Writes a map as Radiance `.hdr`, OpenEXR `.exr` (ZIP) or portable float map `.pfm`, depending on the extension; see
/// [`encode_picture`].
///
/// The file is written under a temporary name in the same folder and then renamed: no partial file ever has the final
/// name.
///
/// # Errors
/// [`ImageError::Options`] for another extension, or a map too wide for `.hdr`; [`ImageError::Io`] if the file cannot be
/// written.
pub fn write_env(
    path: impl AsRef<Path>,
    map: &MappedMap,
    options: &PictureWriteOptions,
) -> Result<PictureWriteReport, ImageError> {
    let path = path.as_ref();
    let (bytes, report) = encode_picture(path, map.width(), map.texels(), options)?;
    let io = |source| ImageError::Io { place: path.display().to_string(), source };
    write_atomically(path, |file| file.write_all(&bytes)).map_err(io)?;
    Ok(report)
}

/// Options of writing a cube map.
#[derive(Clone, Debug, Default, PartialEq, Eq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct CubeWriteOptions {
    /// The texel format.
    pub texels: TexelFormat,
    /// Compress `.ktx2` with Zstandard, without loss.
    pub zstd: bool,
}

/// Writes a cube map with all its levels as `.ktx2`, `.dds` or `.ktx`, depending on the extension; see [`write_cube_texture`].
///
/// # Errors
/// Those of [`write_cube_texture`].
pub fn write_cube(
    path: impl AsRef<Path>,
    chain: &CubeMipChain,
    options: &CubeWriteOptions,
) -> Result<PictureWriteReport, ImageError> {
    let levels: Vec<_> = chain.levels().iter().map(|level| (level.size(), level.texels())).collect();
    write_cube_texture(path, &levels, options.texels, options.zstd)
}
