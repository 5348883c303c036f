//! Error type of this crate.

use std::fmt;
use std::io;

/// Errors of making, reading, writing and comparing pictures, by fault.
///
/// Every message is one line: where, what was expected, what was found, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
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
    /// The file may be right, but the caller's [`PictureReadOptions`](crate::PictureReadOptions) do not let it in.
    #[error("{place}: {message}; {option}")]
    Refused {
        /// The file, or the name the caller gave to the bytes.
        place: String,
        /// The content that was refused.
        message: String,
        /// The option that would let it in.
        option: ReadOption,
    },
    /// The caller asked for something that cannot be.
    #[error("{0}")]
    Options(String),
    /// The operating system refused.
    #[error("{place}: {source}")]
    Io {
        /// The file.
        place: String,
        /// The refusal.
        source: io::Error,
    },
}

/// The option of reading that keeps a file out. As text, what a caller of the library can do about it; a program that
/// names its options otherwise says so itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ReadOption {
    /// `max_texels`: the picture has more.
    MaxTexels,
    /// `max_bytes`: the file is longer, or its texels take more.
    MaxBytes,
    /// `nonfinite`: there are texels of NaN or infinity.
    Nonfinite,
    /// `to_rec_709`: the primaries of the file cannot be understood.
    ToRec709,
}

impl fmt::Display for ReadOption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::MaxTexels => "scale it down, or raise max_texels in the options of reading",
            Self::MaxBytes => "make it smaller, or raise max_bytes in the options of reading",
            Self::Nonfinite => "Nonfinite::Zero in the options of reading reads them as black",
            Self::ToRec709 => "without to_rec_709 in the options of reading the values are taken as they are",
        })
    }
}
