//! What can go wrong with a picture of the environment.

use std::io;

use lobe_image::{ImageError, ReadOption};

/// Why an environment map could not be made, read or written, by whose fault it is.
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
        /// What is wrong with it.
        message: String,
    },
    /// The file may be right, but Lobe does not handle such files.
    #[error("{place}: {message}")]
    Unsupported {
        /// The file, or the name the caller gave to the bytes.
        place: String,
        /// What it would need.
        message: String,
    },
    /// The file may be right, but the caller's [`MapReadOptions`](crate::MapReadOptions) do not let it in.
    #[error("{place}: {message}; {option}")]
    Refused {
        /// The file, or the name the caller gave to the bytes.
        place: String,
        /// What it holds.
        message: String,
        /// The option that would let it in.
        option: ReadOption,
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
            ImageError::Refused { place, message, option } => Self::Refused { place, message, option },
            ImageError::Io { place, source } => Self::Io { place, source },
            other => Self::Options(other.to_string()),
        }
    }
}
