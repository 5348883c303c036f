//! Readers of cube maps.

use std::path::Path;

use lobe_image::{CubeTexture, FileFormat, Picture, read_cube_texture_bytes, read_picture_file};
use lobe_sh::Rgb;

use crate::files::exr_envmap;
use crate::files::read_env::{Shape, decode_picture, lat_long};
use crate::files::read_options::{MapReadOptions, MapReadReport};
use crate::{CubeMap, CubeMipChain, EnvError, EnvMap};

/// The content of an environment map file.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvFile {
    /// A lat-long map.
    LatLong(EnvMap),
    /// A cube map, with the levels that the file has.
    Cube(CubeMipChain),
}

/// Reads a lat-long map or a cube map, depending on the file.
///
/// Textures are cube maps, and so is an OpenEXR picture whose attribute `envmap` says so; everything else is read as
/// [`read_env`](crate::read_env) reads it.
///
/// # Errors
/// As [`read_env`](crate::read_env) and [`read_cube`].
pub fn read_env_file(path: impl AsRef<Path>, options: &MapReadOptions) -> Result<(EnvFile, MapReadReport), EnvError> {
    let (name, bytes) = read_picture_file(path)?;
    read_env_file_bytes(&bytes, &name, options)
}

/// Reads a lat-long map or a cube map from the bytes of a file; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_env_file`], except [`EnvError::Io`].
pub fn read_env_file_bytes(
    bytes: &[u8],
    name: &str,
    options: &MapReadOptions,
) -> Result<(EnvFile, MapReadReport), EnvError> {
    if FileFormat::of_bytes(bytes, name)?.is_texture() {
        let (chain, report) = read_cube_bytes(bytes, name, options)?;
        return Ok((EnvFile::Cube(chain), report));
    }
    let (picture, report) = decode_picture(bytes, name, options, Shape::Said)?;
    if picture.width() == 2 * picture.height() {
        return Ok((EnvFile::LatLong(lat_long(picture, &report)), report));
    }
    let (chain, report) = cube_of_picture(picture, report)?;
    Ok((EnvFile::Cube(chain), report))
}

/// Reads a cube map from a KTX2, DDS or OpenEXR file.
///
/// The format is detected from the file's contents, not from its name. Faces, their order and handedness are those of
/// [`CubeMap`].
///
/// * **KTX2**: RGBA16F, RGBA32F, RGB9E5 and BC6H with and without sign, stored as they are or with Zstandard, any
///   number of levels. Alpha is ignored.
/// * **DDS**: the same formats, with the header of Direct3D 10 or, for RGBA16F and RGBA32F, without it.
/// * **OpenEXR**: a picture of six faces one above another whose attribute `envmap` is `cube`. Its faces have other
///   directions and their outer texels on the edges; each texel is interpolated in its own direction.
///
/// ```
/// use lobe_env::{CubeMap, CubeMipChain, CubeWriteOptions, MapReadOptions, read_cube, write_cube};
/// use lobe_sh::Rgb;
///
/// let path = std::env::temp_dir().join(format!("lobe-read-cube-{}.ktx2", std::process::id()));
/// let sky = CubeMipChain::averaged(CubeMap::from_fn(8, |s| Rgb::new(0.5, 0.5, 1.0 + s.z() as f32)));
/// write_cube(&path, &sky, &CubeWriteOptions::default())?;
/// let (read, report) = read_cube(&path, &MapReadOptions::default())?;
/// std::fs::remove_file(path).ok();
/// assert_eq!((report.width, report.levels), (8, 4));
/// // RGBA16F keeps three digits.
/// assert!((read.base().texel(2, 0, 0).b / sky.base().texel(2, 0, 0).b - 1.0).abs() < 1e-3);
/// # Ok::<(), lobe_env::EnvError>(())
/// ```
///
/// # Errors
/// [`EnvError::Io`] if the file cannot be read; [`EnvError::Invalid`] if it is damaged or cut off;
/// [`EnvError::Refused`] if it is larger than [`MapReadOptions::max_texels`] in its largest level, or has non-finite
/// texels that the options do not allow;
/// [`EnvError::Unsupported`] if it holds no cube map, or one in a form that Lobe does not read.
pub fn read_cube(path: impl AsRef<Path>, options: &MapReadOptions) -> Result<(CubeMipChain, MapReadReport), EnvError> {
    let (name, bytes) = read_picture_file(path)?;
    read_cube_bytes(&bytes, &name, options)
}

/// Reads a cube map from the bytes of a file; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_cube`], except [`EnvError::Io`].
pub fn read_cube_bytes(
    bytes: &[u8],
    name: &str,
    options: &MapReadOptions,
) -> Result<(CubeMipChain, MapReadReport), EnvError> {
    if FileFormat::of_bytes(bytes, name)? == FileFormat::OpenExr {
        let (picture, report) = decode_picture(bytes, name, options, Shape::Cube)?;
        return cube_of_picture(picture, report);
    }
    let (texture, report) = read_cube_texture_bytes(bytes, name, &options.of_picture())?;
    Ok((cube_of_texture(texture)?, report.into()))
}

/// The cube map of a texture.
pub(crate) fn cube_of_texture(texture: CubeTexture) -> Result<CubeMipChain, EnvError> {
    let levels = texture.levels.into_iter();
    let levels = levels.map(|(size, texels)| CubeMap::new(size, texels.into_iter().map(Rgb::from).collect()));
    CubeMipChain::new(levels.collect::<Result<_, _>>()?)
}

fn cube_of_picture(picture: Picture, mut report: MapReadReport) -> Result<(CubeMipChain, MapReadReport), EnvError> {
    report.height = report.width;
    Ok((cube_of_edges(picture)?, report))
}

/// The cube map from OpenEXR's faces one above another.
pub(crate) fn cube_of_edges(picture: Picture) -> Result<CubeMipChain, EnvError> {
    let map = exr_envmap::cube_from_edges(picture.width(), &picture.into_pixels::<Rgb<f32>>())?;
    Ok(CubeMipChain::single(map))
}
