//! Error type of this crate.

use std::io;

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
    /// The scene has more of something than a limit among [`SceneReadOptions`](crate::SceneReadOptions) allows.
    #[error("{message}: raise SceneReadOptions::{}", limit.name())]
    TooLarge {
        /// The file, the limit, and what was found.
        message: String,
        /// The limit.
        limit: SceneLimit,
    },
    /// The operating system refused.
    #[error("{place}: {source}")]
    Io {
        /// The file.
        place: String,
        /// The refusal.
        source: io::Error,
    },
}

/// The limits of reading a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SceneLimit {
    /// Of triangles and of vertices: [`SceneReadOptions::limit`](crate::SceneReadOptions::limit).
    Triangles,
    /// [`SceneReadOptions::texel_limit`](crate::SceneReadOptions::texel_limit).
    Texels,
    /// [`SceneReadOptions::memory_limit`](crate::SceneReadOptions::memory_limit).
    Memory,
}

impl SceneLimit {
    fn name(self) -> &'static str {
        match self {
            Self::Triangles => "limit",
            Self::Texels => "texel_limit",
            Self::Memory => "memory_limit",
        }
    }
}

impl SceneError {
    pub(crate) fn invalid(place: &str, message: impl Into<String>) -> Self {
        Self::Invalid { place: place.to_string(), message: message.into() }
    }

    pub(crate) fn unsupported(place: &str, message: impl Into<String>) -> Self {
        Self::Unsupported { place: place.to_string(), message: message.into() }
    }

    /// The same error, located in the file it was found in.
    pub(crate) fn within(self, file: &str) -> Self {
        match self {
            Self::Invalid { place, message } => Self::Invalid { place: format!("{file}: {place}"), message },
            Self::Unsupported { place, message } => Self::Unsupported { place: format!("{file}: {place}"), message },
            other => other,
        }
    }
}
