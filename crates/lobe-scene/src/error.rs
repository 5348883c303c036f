//! Error type of this crate.

use std::io;

use lobe_io::{OptionError, one_line};

/// Errors of making, reading and changing scenes, by fault.
///
/// Every message is one line: where, what was expected, what was found, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file or the data contradict themselves, are cut off, or describe no scene.
    #[error("{place}: {message}")]
    Invalid {
        /// The file, the name the caller gave to the bytes, or the part of the scene.
        place: String,
        /// The fault.
        message: String,
    },
    /// The file may be right, but Lobe does not read such files.
    #[error("{place}: {message}")]
    Unsupported {
        /// The file, or the name the caller gave to the bytes.
        place: String,
        /// The missing feature, and a remedy.
        message: String,
    },
    /// The caller asked for something that cannot be.
    #[error("{0}")]
    Options(String),
    /// An option of a job is refused.
    #[error(transparent)]
    OfJob(#[from] OptionError),
    /// The file has more of something than an option of reading allows.
    #[error("{place}: {message}: raise SceneReadOptions::{}", option.name())]
    Refused {
        /// The file, or the name the caller gave to the bytes.
        place: String,
        /// The limit, and what was found.
        message: String,
        /// The option that would let it in.
        option: SceneReadOption,
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

/// The options of reading a scene that are limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SceneReadOption {
    /// [`SceneReadOptions::max_triangles`](crate::SceneReadOptions::max_triangles), of vertices too.
    MaxTriangles,
    /// [`SceneReadOptions::max_texels`](crate::SceneReadOptions::max_texels).
    MaxTexels,
    /// [`SceneReadOptions::max_bytes`](crate::SceneReadOptions::max_bytes).
    MaxBytes,
}

impl SceneReadOption {
    fn name(self) -> &'static str {
        match self {
            Self::MaxTriangles => "max_triangles",
            Self::MaxTexels => "max_texels",
            Self::MaxBytes => "max_bytes",
        }
    }
}

impl SceneError {
    pub(crate) fn invalid(place: &str, message: impl Into<String>) -> Self {
        Self::Invalid { place: one_line(place), message: one_line(&message.into()) }
    }

    pub(crate) fn unsupported(place: &str, message: impl Into<String>) -> Self {
        Self::Unsupported { place: one_line(place), message: one_line(&message.into()) }
    }

    /// The same error, located in the file it was found in.
    pub(crate) fn within(self, file: &str) -> Self {
        match self {
            Self::Invalid { place, message } => Self::invalid(&format!("{file}: {place}"), message),
            Self::Unsupported { place, message } => Self::unsupported(&format!("{file}: {place}"), message),
            other => other,
        }
    }
}
