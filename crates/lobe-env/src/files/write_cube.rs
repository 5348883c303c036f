//! Writing cube maps to files.

use std::path::Path;

use lobe_io::write_atomically;
use rayon::prelude::*;

use crate::codec::write_dds;
use crate::codec::write_ktx2;
use crate::{CubeMap, CubeMipChain, EnvError, TexelFormat, WriteReport};

/// How to write a cube map.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CubeWriteOptions {
    /// How each texel is stored.
    pub texels: TexelFormat,
    /// Compress `.ktx2` with Zstandard, without loss.
    pub zstd: bool,
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
) -> Result<WriteReport, EnvError> {
    let path = path.as_ref();
    let wrong = |message: String| EnvError::Options(format!("{}: {message}", path.display()));
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let container = match extension.as_str() {
        "ktx2" => Container::Ktx2,
        "dds" if options.zstd => return Err(wrong("a .dds holds no Zstandard; write .ktx2".into())),
        "dds" => Container::Dds,
        _ => return Err(wrong("a cube map is written as .ktx2 or .dds".into())),
    };
    let mut report = WriteReport::default();
    let mut levels = Vec::with_capacity(chain.levels().len());
    for level in chain.levels() {
        let (faces, clamped) = encode_level(level, options.texels).map_err(wrong)?;
        report.clamped += clamped;
        levels.push(faces);
    }
    let size = chain.base().size();
    let io = |source| EnvError::Io { file: path.display().to_string(), source };
    let pieces = match container {
        Container::Ktx2 => write_ktx2::pieces(size, options.texels, levels, options.zstd).map_err(io)?,
        Container::Dds => write_dds::pieces(size, options.texels, levels),
    };
    write_atomically(path, |file| pieces.iter().try_for_each(|piece| file.write_all(piece))).map_err(io)?;
    Ok(report)
}

enum Container {
    Ktx2,
    Dds,
}

/// The six faces of a level, encoded in parallel, and how many of its texels did not fit.
fn encode_level(level: &CubeMap, format: TexelFormat) -> Result<([Vec<u8>; 6], usize), String> {
    let faces: Vec<_> =
        (0..6).into_par_iter().map(|f| format.encode_face(level.size(), level.face(f))).collect::<Result<_, _>>()?;
    let mut encoded: [Vec<u8>; 6] = Default::default();
    let mut clamped = 0;
    for (out, (bytes, count)) in encoded.iter_mut().zip(faces) {
        *out = bytes;
        clamped += count;
    }
    Ok((encoded, clamped))
}
