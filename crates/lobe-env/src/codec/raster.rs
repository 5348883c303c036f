//! Pictures as they are, before anything is said about directions.

use std::path::Path;

use lobe_sh::Rgb;

use crate::EnvError;
use crate::files::read::{ReadOptions, ReadReport, Shape, decode_picture, read_named};

/// A picture of any shape: one face of a cube, a cross of faces, a mirrored ball, an angular map.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// All texels in linear light, row after row from the top.
    pub texels: Vec<Rgb<f32>>,
}

/// Reads a picture of any shape from the formats of [`read_env`](crate::read_env).
///
/// An attribute `envmap` of an OpenEXR file is not acted upon.
///
/// # Errors
/// As [`read_env`](crate::read_env), but for the shape.
pub fn read_raster(path: impl AsRef<Path>, options: &ReadOptions) -> Result<(Raster, ReadReport), EnvError> {
    let (name, bytes) = read_named(path.as_ref())?;
    read_raster_bytes(&bytes, &name, options)
}

/// Reads a picture of any shape from the bytes of a file; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_raster`], except [`EnvError::Io`].
pub fn read_raster_bytes(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<(Raster, ReadReport), EnvError> {
    let (decoded, report) = decode_picture(bytes, name, options, Shape::Any)?;
    Ok((Raster { width: decoded.width, height: decoded.height, texels: decoded.texels }, report))
}
