//! The errors of this crate. The mathematics has none: it documents its degenerate cases instead.

use alloc::string::String;
#[cfg(feature = "std")]
use std::io;

/// Why an expansion or a rotation could not be made, read or written; the variant says whose fault it is.
///
/// Every message is one line: where, what was expected, what was found, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShError {
    /// The file contradicts itself, is cut off, or is no expansion.
    #[error("{place}: {message}")]
    Invalid {
        /// The file, or the name that the caller gave to the bytes.
        place: String,
        /// The fault.
        message: String,
    },
    /// The file may be right, but Lobe does not handle such files.
    #[error("{place}: {message}")]
    Unsupported {
        /// The file, or the name that the caller gave to the bytes.
        place: String,
        /// The missing support.
        message: String,
    },
    /// The caller asked for something that cannot be.
    #[error("{0}")]
    Options(String),
    /// The caller gave the matrix of a mirror for a rotation.
    #[error("expected a rotation, found a mirror (determinant {determinant:.6}); mirror with AxisPermutation")]
    Mirror {
        /// The determinant found, about -1.
        determinant: f64,
    },
    /// The operating system refused.
    #[cfg(feature = "std")]
    #[error("{place}: {source}")]
    Io {
        /// The file, or the name that the caller gave to the stream.
        place: String,
        /// The refusal of the system.
        source: io::Error,
    },
}
