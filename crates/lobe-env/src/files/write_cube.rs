//! Writing cube maps to files.

use std::path::Path;

use lobe_image::{TexelFormat, write_cube_texture};

use crate::{CubeMipChain, EnvError, MapWriteReport};

/// How to write a cube map.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CubeWriteOptions {
    /// How each texel is stored.
    pub texels: TexelFormat,
    /// Compress `.ktx2` with Zstandard, without loss.
    pub zstd: bool,
}

impl CubeWriteOptions {
    /// Sets how each texel is stored.
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

/// Writes a cube map with all its levels as `.ktx2` or `.dds`, as the extension says.
///
/// Nothing half-written ever has the final name. What a channel cannot hold is moved to the nearest value that it can,
/// and counted over all levels.
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
