//! Writers of maps.

use std::path::Path;

use derive_setters::Setters;
use lobe_image::{
    ImageError, PictureWriteOptions, PictureWriteReport, TexelFormat, encode_picture, write_cube_texture, write_pixels,
};

use crate::{CubeHandedness, CubeMipChain, MappedMap};

/// Writes a map as a picture in its mapping; [`lobe_image::write_picture`] lists the formats.
///
/// Where the proportions of the picture do not tell the mapping ([`MappedMap::untold_mapping`]), the file keeps its name, and
/// [`read_map`](crate::read_map()) finds it again.
///
/// # Errors
/// Those of [`lobe_image::write_picture`].
pub fn write_env(
    path: impl AsRef<Path>,
    map: &MappedMap,
    options: &PictureWriteOptions,
) -> Result<PictureWriteReport, ImageError> {
    write_pixels(path, map.width(), map.texels(), &with_mapping(options, map))
}

/// The bytes that [`write_env`] writes; the extension of the path says the format.
///
/// # Errors
/// Those of [`lobe_image::encode_picture`].
pub fn encode_env(
    path: &Path,
    map: &MappedMap,
    options: &PictureWriteOptions,
) -> Result<(Vec<u8>, PictureWriteReport), ImageError> {
    encode_picture(path, map.width(), map.texels(), &with_mapping(options, map))
}

/// The options with the name of the mapping, where a picture in it does not tell.
fn with_mapping(options: &PictureWriteOptions, map: &MappedMap) -> PictureWriteOptions {
    let mut options = options.clone();
    options.mapping = options.mapping.or_else(|| map.untold_mapping().map(str::to_owned));
    options
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
    /// The handedness for which the faces are made; only `.ktx2` has room to say which. Default: right.
    pub handedness: CubeHandedness,
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
    let turned = (options.handedness == CubeHandedness::Left).then(|| chain.clone().of_handedness(options.handedness));
    let levels = turned.as_ref().unwrap_or(chain).levels();
    let levels: Vec<_> = levels.iter().map(|level| (level.size(), level.texels())).collect();
    write_cube_texture(path, &levels, options.texels, options.zstd, options.handedness.mapping_name())
}
