//! What can go wrong around an expansion; the mathematics itself documents its degenerate cases instead.

use std::io;

/// Why an expansion or a rotation could not be made, read or written, by whose fault it is.
///
/// Every message is one line: where, what was expected, what was found, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShError {
    /// The file contradicts itself, is cut off, or is no expansion.
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
    /// The operating system refused.
    #[error("{file}: {source}")]
    Io {
        /// The file.
        file: String,
        /// The refusal.
        source: io::Error,
    },
}
