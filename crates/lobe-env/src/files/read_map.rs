//! Readers of any map: the mapping is declared by the file, by the caller, or follows from the proportions.

use std::path::Path;

use lobe_image::{
    EnvmapAttribute, FileFormat, ImageError, Picture, PictureReadReport, is_cube_texture_bytes, picture_file_bytes,
    read_cube_texture_bytes, read_picture_bytes, read_texture_picture_bytes,
};
use lobe_io::Job;
use lobe_sh::Rgb;

use crate::error::EnvError;
use crate::files::bundled;
use crate::files::cropped::{Shown, whole_map};
use crate::files::cube_faces::{FaceFiles, read_cube_faces};
use crate::files::exr_envmap::{cube_from_edges, lat_long_from_edges};
use crate::files::fisheye::fisheye_map;
use crate::files::panorama;
use crate::files::read_options::{FaceAssumption, MapReadOptions, MapReadReport};
use crate::map::cube_handedness::CubeHandedness;
use crate::map::cube_layout::CubeLayout;
use crate::map::cube_map::CubeMap;
use crate::map::cube_mip_chain::CubeMipChain;
use crate::map::env_map::EnvMap;
use crate::map::face_order::{FaceNames, FaceOrder};
use crate::map::mapped_map::MappedMap;
use crate::mapping::fisheye::rounded_degrees;
use crate::mapping::mapping::Mapping;

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
            Self::Chain(chain) => chain.base(),
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

    /// The cube with its levels; of a cube in a picture or in six files, that one level.
    ///
    /// # Errors
    /// [`EnvError::Options`] if it is no cube.
    pub fn into_chain(self) -> Result<CubeMipChain, EnvError> {
        match self {
            Self::Single(map) => map.into_cube_map().map(CubeMipChain::single),
            Self::Chain(chain) => Ok(chain),
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
        MappedMap::load(path)?.into_lat_long(Job::default())
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
/// The format is detected from the file's contents, not from its name.
///
/// * `FOLDER/PREFIX%.EXT` stands for the six faces of a cube as [`FaceFiles::to_read`] names them, `FOLDER` for the one
///   cube in it, `bundled:NAME` for a map that is [part of the library](crate::bundled).
/// * A texture (KTX2, KTX, DDS; [`read_cube_texture_bytes`] lists the texel formats) is a cube map, or if it holds a
///   single picture, that. Faces, their order and handedness are those of [`CubeMap`].
/// * Another picture ([`lobe_image::read_picture`] lists the formats) is in the mapping of [`MapReadOptions::mapping`].
///   By default it is the one that [`write_env`](crate::write_env) has written into the file, or it follows from the
///   proportions: lat-long if the picture is twice as wide as high, a cube if it is a cross, a row or a column of six
///   faces, which [`MapReadReport::layout`] reports.
/// * With the attribute `envmap` of OpenEXR a picture is a lat-long map or a cube, whose outer texels lie on the edges
///   of the picture or of its faces, as the format defines it: unless a mapping is asked for, the map is moved to
///   Lobe's centers by interpolation. The center of the lat-long picture, the format's +z, becomes +x as in every
///   lat-long picture, and the cube turns alike: `(x, y, z)` is the format's `(Z, X, Y)`.
///
/// * A panorama that shows all around but not all of the height is completed by [`MapReadOptions::elevations`]. One
///   whose XMP says that it is a crop, as cameras write it (`GPano`), lies where that says. What it does not show is
///   [`MapReadOptions::padding`].
///
/// * The round picture of a fisheye lens becomes a lat-long map by [`MapReadOptions::fisheye`], unless the file says
///   that it is a map already.
///
/// * The faces of a cube that a tool for panoramas made are photographs, in an order of its own:
///   [`MapReadOptions::faces`] says which. Six files that are named by sides, as front and back, are taken for
///   photographs. [`MapReadReport::assumed`] is what was assumed.
///
/// * Faces of a cube that [`write_cube`](crate::write_cube()) and [`write_cube_faces`](crate::write_cube_faces) made
///   left-handed are turned around again, but from `.dds`, `.ktx` and `.pfm`, which have no room to say so: for them,
///   and for other programs' files, there is [`MapReadOptions::handedness`].
///
/// A file is opened and decoded once.
///
/// ```
/// use lobe_env::{CubeMap, CubeMipChain, CubeWriteOptions, MapReadOptions, read_map, write_cube};
/// use lobe_sh::Rgb;
///
/// let path = std::env::temp_dir().join(format!("lobe-read-map-{}.ktx2", std::process::id()));
/// let sky = CubeMipChain::averaged(CubeMap::from_fn(8, |s| Rgb::new(0.5, 0.5, 1.0 + s.z() as f32)));
/// write_cube(&path, &sky, &CubeWriteOptions::default())?;
/// let (read, report) = read_map(&path, &MapReadOptions::default())?;
/// std::fs::remove_file(path).ok();
/// assert_eq!((report.picture.width, report.picture.levels), (8, 4));
/// // RGBA16F keeps three digits.
/// let (read, up) = (read.into_chain()?, lobe_sh::Dir::Z);
/// assert!((read.base().radiance(up).b / sky.base().radiance(up).b - 1.0).abs() < 1e-3);
/// # Ok::<(), lobe_env::EnvError>(())
/// ```
///
/// # Errors
/// [`EnvError::Image`] if the file cannot be read, is damaged, or is kept out by [`MapReadOptions::picture`];
/// [`EnvError::UnknownMapping`] if neither the file nor its proportions determine the mapping;
/// [`EnvError::Contradiction`] if options and file contradict each other; [`EnvError::Options`] if the picture cannot
/// be a map of the requested mapping, or there is no bundled map of the name.
pub fn read_map(path: impl AsRef<Path>, options: &MapReadOptions) -> Result<(LoadedMap, MapReadReport), EnvError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    if let Some(bundled) = name.strip_prefix(bundled::PREFIX) {
        options.expect(Mapping::LatLong, &name, "lat-long")?;
        options.expect_no_fisheye(&name, "lat-long")?;
        return read_map_bytes(bundled::named(bundled)?.bytes, &name, options);
    }
    let Some(files) = FaceFiles::of_input(path)? else {
        let (name, bytes) = picture_file_bytes(path, &options.picture)?;
        return read_map_bytes(&bytes, &name, options);
    };
    options.expect(Mapping::Cube, &name, "a cube")?;
    let (cube, faces, assumed) = read_cube_faces(&files, options)?;
    Ok((LoadedMap::Single(cube.into()), MapReadReport { assumed, faces: faces.clone(), ..faces[0].clone().into() }))
}

/// Reads a map of any mapping from the bytes of a file; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_map`].
pub fn read_map_bytes(
    bytes: &[u8],
    name: &str,
    options: &MapReadOptions,
) -> Result<(LoadedMap, MapReadReport), EnvError> {
    let mut told = Vec::new();
    let is_texture = FileFormat::of_bytes(bytes, name)?.is_texture();
    let mut read = if is_texture && is_cube_texture_bytes(bytes, name, &options.picture)? {
        options.expect(Mapping::Cube, name, "a cube map")?;
        let (texture, report) = read_cube_texture_bytes(bytes, name, &options.picture)?;
        let options = options.for_file(report.mapping.as_deref(), &mut told);
        let levels = texture.levels.into_iter();
        let order = options.faces.unwrap_or(FaceOrder::usual(FaceNames::Axes));
        let levels = levels.map(|(size, texels)| {
            let mut faces = texels.chunks_exact(size * size).map(|face| face.iter().copied().map(Rgb::from).collect());
            order.cube(size, std::array::from_fn(|_| faces.next().unwrap_or_default()), options.hand())
        });
        let chain = CubeMipChain::new(levels.collect::<Result<_, _>>()?)?;
        (LoadedMap::Chain(chain), report.into())
    } else {
        let read_bytes = if is_texture { read_texture_picture_bytes } else { read_picture_bytes };
        let (picture, report) = read_bytes(bytes, name, &options.picture)?;
        let options = &options.for_file(report.mapping.as_deref(), &mut told);
        let kept = report.mapping.as_deref().and_then(Mapping::from_name);
        let is_cube = CubeHandedness::is_told(report.mapping.as_deref());
        let known = kept.or(is_cube.then_some(Mapping::Cube)).map(Mapping::name);
        if let Some(found) = known.or(report.envmap.map(|_| "a map by its attribute envmap")) {
            options.expect_no_fisheye(name, found)?;
        }
        let is_told = options.asked().is_some() || report.envmap.is_some() || kept.is_some();
        let size = [picture.width(), picture.height()];
        let shown = if is_told {
            told.extend(panorama::passed_over(&report.panorama, size));
            None
        } else {
            panorama::shown(&report.panorama, size, options.padding, name, &mut told)?
        };
        match (options.asked(), report.envmap, kept) {
            (Some(mapping), _, _) => map_of(mapping, picture, report.into(), name, options)?,
            (None, Some(envmap), _) => map_of_edges(envmap, picture, report, name, options)?,
            (None, None, Some(mapping)) => {
                told.push(told_by_file(mapping));
                map_of(mapping, picture, report.into(), name, options)?
            }
            (None, None, None) => match shown {
                Some(shown) => map_of_crop(&picture, &shown, report, name, options)?,
                None => map_as_told(picture, report, name, options)?,
            },
        }
    };
    options.check_handedness(read.0.base().mapping(), name)?;
    let is_plain = read.1.picture.mapping.is_none() && read.1.picture.envmap.is_none() && !is_texture;
    if is_plain && read.0.base().mapping() == Mapping::Cube && options.leaves_faces_open() {
        read.1.assumed = Some(FaceAssumption::RightHanded);
    }
    read.1.told = told;
    Ok(read)
}

/// The map of a picture with the attribute `envmap`.
fn map_of_edges(
    envmap: EnvmapAttribute,
    picture: Picture,
    mut report: PictureReadReport,
    name: &str,
    options: &MapReadOptions,
) -> Result<(LoadedMap, MapReadReport), EnvError> {
    let (width, height) = (picture.width(), picture.height());
    let (is_right, shape) = match envmap {
        EnvmapAttribute::LatLong => (width == 2 * height, "a lat-long map is twice as wide as high"),
        EnvmapAttribute::Cube => (height == 6 * width, "a cube map is six times as high as wide"),
    };
    if !is_right {
        let message = format!("{shape}, but this picture, by its attribute envmap, is {width} x {height}");
        return Err(ImageError::Invalid { place: name.into(), message }.into());
    }
    report.notes.push("by the attribute envmap the outer texels lie on the edges; the map is interpolated".into());
    if envmap == EnvmapAttribute::LatLong {
        let map = lat_long_from_edges(&EnvMap::from_rows(width, height, picture.into_pixels()));
        return Ok((LoadedMap::Single(map.into()), report.into()));
    }
    report.height = width;
    // A left-handed cube has OpenEXR's own X turned around, not that of the cube which it becomes.
    let stored = CubeMap::new(width, picture.into_pixels())?.of_handedness(options.hand());
    Ok((LoadedMap::Chain(CubeMipChain::single(cube_from_edges(&stored))), report.into()))
}

/// The map of a picture that is a crop of a lat-long panorama.
fn map_of_crop(
    picture: &Picture,
    shown: &Shown,
    report: PictureReadReport,
    name: &str,
    options: &MapReadOptions,
) -> Result<(LoadedMap, MapReadReport), EnvError> {
    let map = whole_map(picture, shown, options.padding, &options.picture, name)?;
    Ok((LoadedMap::Single(map.into()), report.into()))
}

/// The map of a picture whose mapping its proportions determine.
fn map_as_told(
    picture: Picture,
    report: PictureReadReport,
    name: &str,
    options: &MapReadOptions,
) -> Result<(LoadedMap, MapReadReport), EnvError> {
    let (width, height) = (picture.width(), picture.height());
    if width == 2 * height {
        return map_of(Mapping::LatLong, picture, report.into(), name, options);
    }
    let Ok(layout) = CubeLayout::of_picture(width, height) else {
        let message =
            format!("a picture of {width} x {height} is neither lat-long (2:1) nor a cube (4:3, 3:4, 6:1 or 1:6)");
        return Err(EnvError::UnknownMapping { place: name.into(), message });
    };
    let report = MapReadReport { layout: Some(layout), ..report.into() };
    map_of(Mapping::Cube, picture, report, name, options)
}

/// The map of a picture of known mapping.
fn map_of(
    mapping: Mapping,
    picture: Picture,
    mut report: MapReadReport,
    name: &str,
    options: &MapReadOptions,
) -> Result<(LoadedMap, MapReadReport), EnvError> {
    options.check_fisheye(name)?;
    options.expect(mapping, name, mapping.name())?;
    let named = |error: EnvError| EnvError::Options(format!("{name}: {error}"));
    let (width, height) = (picture.width(), picture.height());
    let mut note = |note: String| report.picture.notes.push(note);
    let map = match (mapping, options.elevations, &options.fisheye) {
        (Mapping::Cube, ..) => {
            let order = options.faces.unwrap_or(FaceOrder::usual(FaceNames::Axes));
            CubeMap::from_picture_in_order(&picture, &order, options.hand()).map_err(named)?.into()
        }
        (_, _, Some(fisheye)) => {
            let map = fisheye_map(picture, fisheye, options.padding, &options.picture, name)?;
            note(fisheye.remark(&map));
            map.into()
        }
        (_, Some(elevations), None) => {
            let shown = Shown::around(elevations, name)?;
            let map = whole_map(&picture, &shown, options.padding, &options.picture, name)?;
            // The degrees that were given, without the rounding of their change to radians.
            let [low, high] = elevations.map(rounded_degrees);
            let (width, height) = (map.width(), map.height());
            note(format!("it shows the elevations {low}° to {high}° of a map of {width} x {height}"));
            map.into()
        }
        (_, None, None) => {
            if let Some(remark) = unusual_lat_long(width, height).filter(|_| mapping == Mapping::LatLong) {
                note(remark);
            }
            MappedMap::new(mapping, width, height, picture.into_pixels::<Rgb<f32>>()).map_err(named)?
        }
    };
    Ok((LoadedMap::Single(map), report))
}

/// A remark on the proportions of a lat-long picture.
pub(crate) fn unusual_lat_long(width: usize, height: usize) -> Option<String> {
    (width != 2 * height).then(|| format!("{width} x {height} is not 2:1; taken to show all elevations, -90° to 90°"))
}

/// A remark on a mapping that the file tells.
pub(crate) fn told_by_file(mapping: Mapping) -> String {
    format!("the map is {mapping}, as the file says")
}
