//! Errors of results on disk.

use std::io;
use std::path::Path;

/// Why results could not be kept on disk or taken up from there, by whose fault it is.
///
/// Every message is one line: where, what was expected, what was found, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The file holds something else than it should.
    #[error("{place}: {message}")]
    Invalid {
        /// The file.
        place: String,
        /// What is wrong with it.
        message: String,
    },
    /// The file is of a version that is not read.
    #[error("{place}: {message}")]
    Unsupported {
        /// The file.
        place: String,
        /// Which version it is of, and what to do.
        message: String,
    },
    /// The watch of the job said to stop.
    #[error("stopped before the end")]
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

impl IoError {
    pub(crate) fn invalid(path: &Path, message: impl Into<String>) -> Self {
        Self::Invalid { place: path.display().to_string(), message: message.into() }
    }

    /// The refusal of the system, at this file.
    #[must_use]
    pub fn io(path: &Path, source: io::Error) -> Self {
        Self::Io { place: path.display().to_string(), source }
    }
}

/// The bytes of a file.
///
/// # Errors
/// [`IoError::Io`] if it cannot be read.
pub fn read_file(path: &Path) -> Result<Vec<u8>, IoError> {
    std::fs::read(path).map_err(|source| IoError::io(path, source))
}
