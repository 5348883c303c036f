//! Writers of cube maps.

use std::path::Path;

use lobe_image::{TexelFormat, write_cube_texture};

use crate::{CubeMipChain, EnvError, MapWriteReport};

/// Options of writing a cube map.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CubeWriteOptions {
    /// The texel format.
    pub texels: TexelFormat,
    /// Compress `.ktx2` with Zstandard, without loss.
    pub zstd: bool,
}

impl CubeWriteOptions {
    /// Sets the texel format.
    #[must_use]
    pub fn texels(self, texels: TexelFormat) -> Self {
        Self { texels, ..self }
    }

    /// Sets whether `.ktx2` is compressed with Zstandard.
    #[must_use]
    pub fn zstd(self, zstd: bool) -> Self {
        Self { zstd, ..self }
    }
}

/// Writes a cube map with all its levels as `.ktx2` or `.dds`, depending on the extension.
///
/// No partial file ever has the final name. Channels outside the range of the texel format are clamped to it, and
/// counted over all levels.
///
/// # Errors
/// [`EnvError::Options`] for another extension, Zstandard in `.dds`, a format that is not written, or BC6H without the
/// feature `bc6h`; [`EnvError::Io`] if the file cannot be written.
pub fn write_cube(
    path: impl AsRef<Path>,
    chain: &CubeMipChain,
    options: &CubeWriteOptions,
) -> Result<MapWriteReport, EnvError> {
    let levels: Vec<_> = chain.levels().iter().map(|level| (level.size(), level.texels())).collect();
    Ok(write_cube_texture(path, &levels, options.texels, options.zstd)?.into())
}
