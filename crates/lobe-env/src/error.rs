//! Error type of this crate.

use std::fmt;

use lobe_image::ImageError;
use lobe_io::IoError;

/// Errors of making, reading and writing environment maps, by fault.
///
/// Every message is one line: where, what was expected, what was found, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EnvError {
    /// The picture or texture of the map cannot be read or written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A file that is no map cannot be read.
    #[error(transparent)]
    File(#[from] IoError),
    /// Nothing tells the mapping of a picture.
    #[error(
        "{place}: {message}; say what it is with MapReadOptions::mapping or fisheye, or what a cropped panorama shows with elevations"
    )]
    UnknownMapping {
        /// The file, or the name the caller gave to the bytes.
        place: String,
        /// The picture that was found, and what was expected.
        message: String,
    },
    /// The file says what it is, and the caller's [`MapReadOptions`](crate::MapReadOptions) say otherwise.
    #[error("{place} is {found}; leave {option} at its default")]
    Contradiction {
        /// The file, or the name the caller gave to the bytes.
        place: String,
        /// The mapping in the file.
        found: String,
        /// The option that says otherwise.
        option: MapReadOption,
    },
    /// The caller asked for something that cannot be.
    #[error("{0}")]
    Options(String),
    /// The caller's progress callback asked to stop.
    #[error("stopped before the end")]
    Cancelled,
}

/// The option of [`MapReadOptions`](crate::MapReadOptions) that contradicts a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MapReadOption {
    /// [`mapping`](crate::MapReadOptions::mapping): it is another than the file's.
    Mapping,
    /// [`handedness`](crate::MapReadOptions::handedness): only cubes have one.
    Handedness,
    /// [`elevations`](crate::MapReadOptions::elevations): only lat-long pictures are cropped.
    Elevations,
    /// [`fisheye`](crate::MapReadOptions::fisheye): only of a picture that is no map yet.
    Fisheye,
    /// [`faces`](crate::MapReadOptions::faces): only cubes have them.
    Faces,
}

impl fmt::Display for MapReadOption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mapping => "MapReadOptions::mapping",
            Self::Handedness => "MapReadOptions::handedness",
            Self::Elevations => "MapReadOptions::elevations",
            Self::Fisheye => "MapReadOptions::fisheye",
            Self::Faces => "MapReadOptions::faces",
        })
    }
}
