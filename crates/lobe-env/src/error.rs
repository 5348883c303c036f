//! What can go wrong with a picture of the environment.

use std::fmt;
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
    /// The file may be right, but the caller's [`ReadOptions`](crate::ReadOptions) do not let it in.
    #[error("{file}: {message}; {option}")]
    Refused {
        /// The file, or the name the caller gave to the bytes.
        file: String,
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
    #[error("{file}: {source}")]
    Io {
        /// The file.
        file: String,
        /// The refusal.
        source: io::Error,
    },
}

/// The option of [`ReadOptions`](crate::ReadOptions) that keeps a file out. As text, what a caller of the library can do
/// about it; a program that names its options otherwise says so itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ReadOption {
    /// [`ReadOptions::max_texels`](crate::ReadOptions::max_texels): the picture has more.
    MaxTexels,
    /// [`ReadOptions::nonfinite`](crate::ReadOptions::nonfinite): there are texels of NaN or infinity.
    Nonfinite,
}

impl fmt::Display for ReadOption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::MaxTexels => "scale it down, or raise ReadOptions::max_texels",
            Self::Nonfinite => "Nonfinite::Zero in ReadOptions::nonfinite reads them as black",
        })
    }
}
