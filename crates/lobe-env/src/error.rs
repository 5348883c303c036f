//! Error type of this crate.

use std::fmt;
use std::io;

use lobe_image::{ImageError, ReadOption};

/// Errors of making, reading and writing environment maps, by fault.
///
/// Every message is one line: where, what was expected, what was found, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EnvError {
    /// The file contradicts itself, is cut off, or is no picture.
    #[error("{place}: {message}")]
    Invalid {
        /// The file, or the name the caller gave to the bytes.
        place: String,
        /// The fault.
        message: String,
    },
    /// The file may be right, but Lobe does not handle such files.
    #[error("{place}: {message}")]
    Unsupported {
        /// The file, or the name the caller gave to the bytes.
        place: String,
        /// The missing feature.
        message: String,
    },
    /// The file may be right, but the caller's [`MapReadOptions`](crate::MapReadOptions) do not let it in.
    #[error("{place}: {message}; {}", option.advice())]
    Refused {
        /// The file, or the name the caller gave to the bytes.
        place: String,
        /// The content that was refused.
        message: String,
        /// The option that would let it in.
        option: MapReadOption,
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
    #[error("stopped before it was done")]
    Cancelled,
    /// The operating system refused.
    #[error("{place}: {source}")]
    Io {
        /// The file.
        place: String,
        /// The refusal.
        source: io::Error,
    },
}

impl From<ImageError> for EnvError {
    fn from(error: ImageError) -> Self {
        match error {
            ImageError::Invalid { place, message } => Self::Invalid { place, message },
            ImageError::Unsupported { place, message } => Self::Unsupported { place, message },
            ImageError::Refused { place, message, option } => Self::Refused { place, message, option: option.into() },
            ImageError::Io { place, source } => Self::Io { place, source },
            other => Self::Options(other.to_string()),
        }
    }
}

/// The option of [`MapReadOptions`](crate::MapReadOptions) that keeps a file out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MapReadOption {
    /// [`max_texels`](crate::MapReadOptions::max_texels): the picture has more.
    MaxTexels,
    /// [`nonfinite`](crate::MapReadOptions::nonfinite): there are texels of NaN or infinity.
    Nonfinite,
    /// [`mapping`](crate::MapReadOptions::mapping): it is missing where nothing else tells, or another than the file's.
    Mapping,
    /// [`handedness`](crate::MapReadOptions::handedness): only cubes have one.
    Handedness,
}

impl MapReadOption {
    /// Advice for a caller of the library; a program that names its options otherwise gives its own.
    fn advice(self) -> &'static str {
        match self {
            Self::MaxTexels => "scale it down, or raise MapReadOptions::max_texels",
            Self::Nonfinite => "Nonfinite::Zero in MapReadOptions::nonfinite reads them as black",
            Self::Mapping => "say what it is with MapReadOptions::mapping",
            Self::Handedness => "leave MapReadOptions::handedness at its default",
        }
    }
}

impl fmt::Display for MapReadOption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::MaxTexels => "MapReadOptions::max_texels",
            Self::Nonfinite => "MapReadOptions::nonfinite",
            Self::Mapping => "MapReadOptions::mapping",
            Self::Handedness => "MapReadOptions::handedness",
        })
    }
}

impl From<ReadOption> for MapReadOption {
    fn from(option: ReadOption) -> Self {
        match option {
            ReadOption::Nonfinite => Self::Nonfinite,
            _ => Self::MaxTexels,
        }
    }
}
