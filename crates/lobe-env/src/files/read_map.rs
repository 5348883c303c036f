//! Readers of any map: the mapping is declared by the file, by the caller, or follows from the proportions.

use std::path::Path;

use lobe_image::{
    EnvmapAttribute, FileFormat, Picture, PictureReadReport, read_cube_texture_bytes, read_picture_bytes,
    read_picture_file,
};
use lobe_sh::Rgb;

use crate::files::bundled;
use crate::files::cube_faces::{face_files, read_cube_faces};
use crate::files::read_cube::{cube_of_edges, cube_of_texture};
use crate::files::read_env::{lat_long, read_env_bytes};
use crate::files::read_options::{MapReadOptions, MapReadReport};
use crate::{CubeLayout, CubeMap, CubeMipChain, EnvError, EnvMap, MapReadOption, MappedMap, Mapping};

/// A map as a file holds it.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadedMap {
    /// One picture, in the mapping of the file.
    Single(MappedMap),
    /// A cube map with the levels that the file has.
    Chain(CubeMipChain),
}

impl LoadedMap {
    /// The largest level.
    #[must_use]
    pub fn base(&self) -> &MappedMap {
        match self {
            Self::Single(map) => map,
            Self::Chain(chain) => chain.base().as_ref(),
        }
    }

    /// The largest level, without the others.
    #[must_use]
    pub fn into_base(self) -> MappedMap {
        match self {
            Self::Single(map) => map,
            Self::Chain(chain) => chain.into_base().into(),
        }
    }
}

impl EnvMap {
    /// Loads a map from a file of any kind and mapping ([`read_map`]); other mappings are resampled to about as many
    /// lat-long texels ([`MappedMap::into_lat_long`]).
    ///
    /// ```
    /// use lobe_env::EnvMap;
    ///
    /// let sunset = EnvMap::load("bundled:sunset")?;
    /// assert_eq!((sunset.width(), sunset.height()), (512, 256));
    /// # Ok::<(), lobe_env::EnvError>(())
    /// ```
    ///
    /// # Errors
    /// As [`read_map`] with default options.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, EnvError> {
        MappedMap::load(path)?.into_lat_long()
    }
}

impl MappedMap {
    /// Loads a map from a file of any kind, in the mapping of the file ([`read_map`]); of a chain of levels the
    /// largest.
    ///
    /// # Errors
    /// As [`read_map`] with default options.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, EnvError> {
        Ok(read_map(path, &MapReadOptions::default())?.0.into_base())
    }
}

/// Reads a map of any mapping from a file of any kind, or from six.
///
/// * `FOLDER/%.EXT` stands for the six faces of a cube as [`cube_face_paths`](crate::cube_face_paths) names them,
///   `bundled:NAME` for a map that is [part of the library](crate::bundled).
/// * A texture (KTX2, DDS) is a cube map, and so is an OpenEXR picture whose attribute `envmap` says so.
/// * Another picture is in the mapping of [`MapReadOptions::mapping`]. By default it follows from the proportions:
///   lat-long if the picture is twice as wide as high, a cube if it is a cross, a row or a column of six faces, which
///   [`MapReadReport::layout`] reports.
///
/// A file is opened and decoded once.
///
/// # Errors
/// Those of [`read_env`](crate::read_env) and [`read_cube`](crate::read_cube()), except for the shape;
/// [`EnvError::Refused`] with [`MapReadOption::Mapping`] if neither the file nor its proportions determine the mapping;
/// [`EnvError::Contradiction`] if options and file contradict each other; [`EnvError::Options`] if the picture cannot
/// be a map of the requested mapping, or there is no bundled map of the name.
pub fn read_map(path: impl AsRef<Path>, options: &MapReadOptions) -> Result<(LoadedMap, MapReadReport), EnvError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    let read = if let Some(bundled) = name.strip_prefix(bundled::PREFIX) {
        options.expect(Mapping::LatLong, &name, "lat-long")?;
        let found = bundled::named(bundled)?;
        let (map, report) = read_env_bytes(found.bytes, found.name, options)?;
        (LoadedMap::Single(map.into()), report)
    } else if let Some((folder, extension)) = face_files(path) {
        options.expect(Mapping::Cube, &name, "a cube")?;
        let (cube, faces) = read_cube_faces(folder, &extension, options.handedness, options)?;
        let report = MapReadReport { faces: faces.to_vec(), ..faces[0].clone() };
        (LoadedMap::Single(cube.into()), report)
    } else {
        let (name, bytes) = read_picture_file(path)?;
        return read_map_bytes(&bytes, &name, options);
    };
    options.check_handedness(read.0.base().mapping(), &name)?;
    Ok(read)
}

/// Reads a map of any mapping from the bytes of a file; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_map`], except [`EnvError::Io`].
pub fn read_map_bytes(
    bytes: &[u8],
    name: &str,
    options: &MapReadOptions,
) -> Result<(LoadedMap, MapReadReport), EnvError> {
    let read = if FileFormat::of_bytes(bytes, name)?.is_texture() {
        options.expect(Mapping::Cube, name, "a cube map")?;
        let (texture, report) = read_cube_texture_bytes(bytes, name, &options.of_picture())?;
        (LoadedMap::Chain(cube_of_texture(texture)?.of_handedness(options.handedness)), report.into())
    } else {
        let (picture, report) = read_picture_bytes(bytes, name, &options.of_picture())?;
        match options.mapping {
            Some(mapping) => (map_of(mapping, picture, name, options)?, report.into()),
            None => map_as_told(picture, report, name, options)?,
        }
    };
    options.check_handedness(read.0.base().mapping(), name)?;
    Ok(read)
}

/// The map of a picture whose mapping the file or its proportions determine.
fn map_as_told(
    picture: Picture,
    report: PictureReadReport,
    name: &str,
    options: &MapReadOptions,
) -> Result<(LoadedMap, MapReadReport), EnvError> {
    let (width, height) = (picture.width(), picture.height());
    let is_cube = report.envmap == Some(EnvmapAttribute::Cube);
    if is_cube && height == 6 * width {
        let report = MapReadReport::of_map(report);
        let chain = cube_of_edges(picture)?.of_handedness(options.handedness);
        return Ok((LoadedMap::Chain(chain), MapReadReport { height: width, ..report }));
    }
    if !is_cube && width == 2 * height {
        let report = MapReadReport::of_map(report);
        return Ok((LoadedMap::Single(lat_long(picture, &report).into()), report));
    }
    let Ok(layout) = CubeLayout::of_picture(width, height) else {
        let message =
            format!("a picture of {width} x {height} is neither lat-long (2:1) nor a cube (4:3, 3:4, 6:1 or 1:6)");
        return Err(EnvError::Refused { place: name.into(), message, option: MapReadOption::Mapping });
    };
    let report = MapReadReport { layout: Some(layout), ..report.into() };
    Ok((map_of(Mapping::Cube, picture, name, options)?, report))
}

/// The map of a picture of known mapping.
fn map_of(mapping: Mapping, picture: Picture, name: &str, options: &MapReadOptions) -> Result<LoadedMap, EnvError> {
    let named = |error: EnvError| EnvError::Options(format!("{name}: {error}"));
    let map = if mapping == Mapping::Cube {
        CubeMap::from_picture(&picture, options.handedness).map_err(named)?.into()
    } else {
        let (width, height) = (picture.width(), picture.height());
        MappedMap::new(mapping, width, height, picture.into_pixels::<Rgb<f32>>()).map_err(named)?
    };
    Ok(LoadedMap::Single(map))
}
