//! The errors of this crate. The mathematics has none: it documents its degenerate cases instead.

use alloc::string::String;
use core::error::Error;
use core::fmt;
#[cfg(feature = "std")]
use std::io;

/// Why an expansion or a rotation could not be made, read or written; the variant says whose fault it is.
///
/// Every message is one line: where, what was expected, what was found, what to do.
#[derive(Debug)]
#[non_exhaustive]
pub enum ShError {
    /// The file contradicts itself, is cut off, or is no expansion.
    Invalid {
        /// The file, or the name that the caller gave to the bytes.
        place: String,
        /// The fault.
        message: String,
    },
    /// The file may be right, but Lobe does not handle such files.
    Unsupported {
        /// The file, or the name that the caller gave to the bytes.
        place: String,
        /// The missing support.
        message: String,
    },
    /// The caller asked for something that cannot be.
    Options(String),
    /// The caller gave the matrix of a mirror for a rotation.
    Mirror {
        /// The determinant found, about -1.
        determinant: f64,
    },
    /// The operating system refused.
    #[cfg(feature = "std")]
    Io {
        /// The file, or the name that the caller gave to the stream.
        place: String,
        /// The refusal of the system.
        source: io::Error,
    },
}

impl fmt::Display for ShError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Invalid { place, message } | Self::Unsupported { place, message } => write!(f, "{place}: {message}"),
            Self::Options(message) => f.write_str(message),
            Self::Mirror { determinant } => write!(
                f,
                "expected a rotation, found a mirror (determinant {determinant:.6}); mirror with AxisPermutation"
            ),
            #[cfg(feature = "std")]
            Self::Io { place, source } => write!(f, "{place}: {source}"),
        }
    }
}

impl Error for ShError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            #[cfg(feature = "std")]
            Self::Io { source, .. } => Some(source),
            _ => None,
        }
    }
}
