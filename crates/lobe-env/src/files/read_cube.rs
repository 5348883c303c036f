//! Reading cube maps from files.

use std::path::Path;

use lobe_sh::Rgb;

use crate::codec::read_dds;
use crate::codec::read_ktx2;
use crate::files::exr_envmap;
use crate::files::read::{
    Decoded, FileFormat, ReadOptions, ReadReport, Shape, decode_picture, format_of, guarded, inspect, invalid,
    lat_long, read_named, unsupported,
};
use crate::{CubeMap, CubeMipChain, EnvError, EnvMap, ReadOption, TexelFormat};

/// A cube map as it comes out of a decoder.
pub(crate) struct DecodedCube {
    pub(crate) format: TexelFormat,
    /// Size and texels of each level, face after face, the largest first.
    pub(crate) levels: Vec<(usize, Vec<Rgb<f32>>)>,
    pub(crate) notes: Vec<String>,
}

/// What a file of surroundings holds.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvFile {
    /// A lat-long map.
    LatLong(EnvMap),
    /// A cube map, with the levels that the file has.
    Cube(CubeMipChain),
}

/// Reads a lat-long map or a cube map, whichever the file holds.
///
/// Textures are cube maps, and so is an OpenEXR picture whose attribute `envmap` says so; everything else is read as
/// [`read_env`](crate::read_env) reads it.
///
/// # Errors
/// As [`read_env`](crate::read_env) and [`read_cube`].
pub fn read_env_file(path: impl AsRef<Path>, options: &ReadOptions) -> Result<(EnvFile, ReadReport), EnvError> {
    let (name, bytes) = read_named(path.as_ref())?;
    read_env_file_bytes(&bytes, &name, options)
}

/// Reads a lat-long map or a cube map from the bytes of a file; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_env_file`], except [`EnvError::Io`].
pub fn read_env_file_bytes(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<(EnvFile, ReadReport), EnvError> {
    if matches!(format_of(bytes, name)?, FileFormat::Ktx2 | FileFormat::Dds) {
        let (chain, report) = read_cube_bytes(bytes, name, options)?;
        return Ok((EnvFile::Cube(chain), report));
    }
    let (decoded, report) = decode_picture(bytes, name, options, Shape::Said)?;
    if decoded.width == 2 * decoded.height {
        return Ok((EnvFile::LatLong(lat_long(decoded)), report));
    }
    let (chain, report) = cube_of_picture(&decoded, report)?;
    Ok((EnvFile::Cube(chain), report))
}

/// Reads a cube map from a KTX2, DDS or OpenEXR file.
///
/// What the file is follows from its contents, not from its name. Faces, their order and their handedness are those of
/// [`CubeMap`].
///
/// * **KTX2**: RGBA16F, RGBA32F, RGB9E5 and BC6H with and without sign, stored as they are or with Zstandard, any
///   number of levels. Alpha is ignored.
/// * **DDS**: the same formats, with the header of Direct3D 10 or, for RGBA16F and RGBA32F, without it.
/// * **OpenEXR**: a picture of six faces one above another whose attribute `envmap` is `cube`. Its faces look
///   elsewhere and have their outer texels on the edges; each texel is interpolated in its own direction.
///
/// ```
/// use lobe_env::{CubeMap, CubeMipChain, CubeWriteOptions, ReadOptions, read_cube, write_cube};
/// use lobe_sh::Rgb;
///
/// let path = std::env::temp_dir().join(format!("lobe-read-cube-{}.ktx2", std::process::id()));
/// let sky = CubeMipChain::averaged(CubeMap::from_fn(8, |s| Rgb::new(0.5, 0.5, 1.0 + s.z() as f32)));
/// write_cube(&path, &sky, &CubeWriteOptions::default())?;
/// let (read, report) = read_cube(&path, &ReadOptions::default())?;
/// std::fs::remove_file(path).ok();
/// assert_eq!((report.width, report.levels), (8, 4));
/// // RGBA16F keeps three digits.
/// assert!((read.base().texel(2, 0, 0).b / sky.base().texel(2, 0, 0).b - 1.0).abs() < 1e-3);
/// # Ok::<(), lobe_env::EnvError>(())
/// ```
///
/// # Errors
/// [`EnvError::Io`] if the file cannot be read; [`EnvError::Invalid`] if it is damaged or cut off;
/// [`EnvError::Refused`] if it is larger than [`ReadOptions::max_texels`] in its largest level, or has non-finite texels
/// that the options do not allow;
/// [`EnvError::Unsupported`] if it holds no cube map, or one in a form that Lobe does not read.
pub fn read_cube(path: impl AsRef<Path>, options: &ReadOptions) -> Result<(CubeMipChain, ReadReport), EnvError> {
    let (name, bytes) = read_named(path.as_ref())?;
    read_cube_bytes(&bytes, &name, options)
}

/// Reads a cube map from the bytes of a file; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_cube`], except [`EnvError::Io`].
pub fn read_cube_bytes(
    bytes: &[u8],
    name: &str,
    options: &ReadOptions,
) -> Result<(CubeMipChain, ReadReport), EnvError> {
    let format = format_of(bytes, name)?;
    let decoded = match format {
        FileFormat::Ktx2 => guarded(format, name, || read_ktx2::decode(bytes, name, options.max_texels))?,
        FileFormat::Dds => guarded(format, name, || read_dds::decode(bytes, name, options.max_texels))?,
        FileFormat::OpenExr => {
            let (decoded, report) = decode_picture(bytes, name, options, Shape::Cube)?;
            return cube_of_picture(&decoded, report);
        }
        other => {
            let message = format!("a cube map in KTX2, DDS or OpenEXR expected, found a {other} picture");
            return Err(unsupported(name, message));
        }
    };
    let size = decoded.levels.first().map_or(0, |(size, _)| *size);
    let mut report = ReadReport::new(size, size, format, decoded.notes);
    report.levels = decoded.levels.len();
    report.notes.insert(0, format!("the texels are {}", decoded.format));
    let mut levels = Vec::with_capacity(decoded.levels.len());
    for (size, mut texels) in decoded.levels {
        inspect(&mut texels, size, &mut report);
        levels.push(CubeMap::new(size, texels)?);
    }
    report.judge(options.nonfinite, name)?;
    Ok((CubeMipChain::new(levels)?, report))
}

/// The cube map from OpenEXR's faces one above another.
fn cube_of_picture(decoded: &Decoded, mut report: ReadReport) -> Result<(CubeMipChain, ReadReport), EnvError> {
    report.height = report.width;
    let map = exr_envmap::cube_from_edges(decoded.width, &decoded.texels)?;
    Ok((CubeMipChain::single(map), report))
}

/// Refuses a cube map larger than the caller allows, before memory is asked for.
pub(crate) fn check_cube_size(size: u64, max_texels: usize, name: &str) -> Result<(), EnvError> {
    if size == 0 {
        return Err(invalid(name, "the cube map has no texels: its faces are 0 x 0".into()));
    }
    if size.checked_mul(size).and_then(|n| n.checked_mul(6)).is_none_or(|texels| texels > max_texels as u64) {
        let message = format!("the faces are {size} x {size}, all six more than the limit of {max_texels} texels");
        return Err(EnvError::Refused { file: name.into(), message, option: ReadOption::MaxTexels });
    }
    Ok(())
}
