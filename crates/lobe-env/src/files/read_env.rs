//! Readers of lat-long maps.

use std::path::Path;

use lobe_image::{
    EnvmapAttribute, FileFormat, ImageError, Picture, PictureHead, read_picture_bytes_if, read_picture_file,
};

use crate::files::exr_envmap;
use crate::files::read_options::{MapReadOptions, MapReadReport};
use crate::{EnvError, EnvMap};

/// Reads a lat-long environment map from a Radiance .hdr, OpenEXR, .pfm, PNG or JPEG file.
///
/// The format is detected from the file's contents, not from its name.
///
/// * **Radiance**: flat, old and new run-length encoding. `EXPOSURE` and `COLORCORR` are divided out, so the values
///   are radiance; `PRIMARIES` is noted and not converted. Rows from the top and columns from the left
///   (`-Y h +X w`) only.
/// * **OpenEXR**: `half` and `float` channels; every compression but HTJ2K; scan lines and tiles, of which the largest
///   level is read; the first part, and in it the first layer, that has channels `R`, `G`, `B` or else `Y`. Alpha
///   and all other channels are ignored. The map is the display window; outside the data window it is black. With the
///   attribute `envmap` the outer texels lie on the edges, as the format defines it: the map is moved to Lobe's
///   centers by interpolation, and the picture's center is the map's +x as for every picture.
/// * **Portable float map**: color and gray, both byte orders, the scale of the header multiplied in.
/// * **PNG, JPEG**: 8 and 16 bits, decoded from sRGB. White is 1 and nothing is brighter, which a note says.
///
/// Cube maps are read by [`read_cube`](crate::read_cube()).
///
/// # Errors
/// [`EnvError::Io`] if the file cannot be read; [`EnvError::Invalid`] if it is damaged, cut off, no such picture or not
/// twice as wide as high; [`EnvError::Refused`] if it is larger than [`MapReadOptions::max_texels`], or has non-finite
/// texels that the options do not allow; [`EnvError::Unsupported`] if it is a kind of picture that Lobe does not read.
pub fn read_env(path: impl AsRef<Path>, options: &MapReadOptions) -> Result<(EnvMap, MapReadReport), EnvError> {
    let (name, bytes) = read_picture_file(path)?;
    read_env_bytes(&bytes, &name, options)
}

/// Reads an environment map from the bytes of a file; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_env`], except [`EnvError::Io`].
pub fn read_env_bytes(bytes: &[u8], name: &str, options: &MapReadOptions) -> Result<(EnvMap, MapReadReport), EnvError> {
    let (picture, report) = decode_picture(bytes, name, options, Shape::LatLong)?;
    Ok((lat_long(picture, &report), report))
}

/// A lat-long map from a picture of that shape.
pub(crate) fn lat_long(picture: Picture, report: &MapReadReport) -> EnvMap {
    let map = EnvMap::from_rows(picture.width(), picture.height(), picture.into_pixels());
    if report.is_edge_centered { exr_envmap::lat_long_from_edges(&map) } else { map }
}

/// Decodes a picture of the given shape.
pub(crate) fn decode_picture(
    bytes: &[u8],
    name: &str,
    options: &MapReadOptions,
    shape: Shape,
) -> Result<(Picture, MapReadReport), EnvError> {
    let format = FileFormat::of_bytes(bytes, name)?;
    if format.is_texture() {
        let message = format!("a lat-long picture expected, found a texture ({format}), which holds a cube map");
        return Err(EnvError::Unsupported { place: name.into(), message });
    }
    let accept = |head: &PictureHead| shape.accept(head, name);
    let (picture, report) = read_picture_bytes_if(bytes, name, &options.of_picture(), accept)?;
    Ok((picture, MapReadReport::of_map(report)))
}

/// The expected shape of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    /// Twice as wide as high.
    LatLong,
    /// Six squares, one above another, said to be a cube map.
    Cube,
    /// As the file declares: a cube map, or else a lat-long map.
    Said,
}

impl Shape {
    /// Refuses a picture of another shape, or one whose attribute `envmap` contradicts the shape.
    fn accept(self, head: &PictureHead, name: &str) -> Result<(), ImageError> {
        let (width, height) = (head.width, head.height);
        let invalid = |message| Err(ImageError::Invalid { place: name.into(), message });
        let unsupported = |message: &str| Err(ImageError::Unsupported { place: name.into(), message: message.into() });
        let is_cube = match (self, head.envmap == Some(EnvmapAttribute::Cube)) {
            (Self::Cube | Self::Said, true) => true,
            (Self::LatLong | Self::Said, false) => false,
            (Self::LatLong, true) => {
                return unsupported("the file says that it is a cube map; a lat-long map is expected");
            }
            (Self::Cube, false) => {
                return unsupported("a cube map expected, but the attribute envmap of the file does not say so");
            }
        };
        if is_cube && height != 6 * width {
            return invalid(format!("a cube map is six times as high as wide, but this picture is {width} x {height}"));
        }
        if !is_cube && width != 2 * height {
            return invalid(format!(
                "a lat-long map is twice as wide as high, but this picture is {width} x {height}; give a full panorama"
            ));
        }
        Ok(())
    }
}
