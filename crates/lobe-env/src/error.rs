//! What can go wrong with a picture of the environment.

use std::io;

/// Why an environment map could not be made, read or written, by whose fault it is.
///
/// Every message is one line: where, what was expected, what was found, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EnvError {
    /// The file contradicts itself, is cut off, or is no picture.
    #[error("{file}: {message}")]
    Invalid {
        /// The file, or the name the caller gave to the bytes.
        file: String,
        /// What is wrong with it.
        message: String,
    },
    /// The file may be right, but Lobe does not handle such files.
    #[error("{file}: {message}")]
    Unsupported {
        /// The file, or the name the caller gave to the bytes.
        file: String,
        /// What it would need.
        message: String,
    },
    /// The caller asked for something that cannot be.
    #[error("{0}")]
    Options(String),
    /// The caller's progress callback asked to stop.
    #[error("stopped before it was done")]
    Cancelled,
    /// The operating system refused.
    #[error("{file}: {source}")]
    Io {
        /// The file.
        file: String,
        /// The refusal.
        source: io::Error,
    },
}
