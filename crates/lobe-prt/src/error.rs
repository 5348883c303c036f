//! The error type of this crate.

use lobe_io::{IoError, OptionError};
use lobe_scene::SceneError;

/// An error of making, reading, writing or changing transfer: a variant for each kind of fault.
///
/// Every message is one line: where, what was expected, what was found, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PrtError {
    /// The file or the data contradict themselves, are cut off, or hold no transfer.
    #[error("{place}: {message}")]
    Invalid {
        /// The file, or the name the caller gave to the data.
        place: String,
        /// What is wrong with it.
        message: String,
    },
    /// The file may be right, but Lobe does not read such files.
    #[error("{place}: {message}")]
    Unsupported {
        /// The file, or the name the caller gave to the data.
        place: String,
        /// What it would need, and what to do.
        message: String,
    },
    /// The caller asked for something that cannot be.
    #[error("{0}")]
    Options(String),
    /// An option of a job is refused.
    #[error(transparent)]
    OfJob(#[from] OptionError),
    /// The watch of the job said to stop.
    #[error("stopped before the end")]
    Cancelled,
    /// The scene is at fault.
    #[error(transparent)]
    Scene(SceneError),
    /// A file could not be read or written, or what is kept in one is at fault.
    #[error(transparent)]
    Io(IoError),
}

impl PrtError {
    pub(crate) fn invalid(place: &str, message: impl Into<String>) -> Self {
        Self::Invalid { place: place.to_string(), message: message.into() }
    }

    /// The same fault, seen from the file it was found in.
    pub(crate) fn within(self, file: &str) -> Self {
        match self {
            Self::Invalid { place, message } => Self::Invalid { place: format!("{file}: {place}"), message },
            other => other,
        }
    }
}

impl From<SceneError> for PrtError {
    /// Work that was stopped is [`PrtError::Cancelled`], wherever it was.
    fn from(error: SceneError) -> Self {
        match error {
            SceneError::Cancelled => Self::Cancelled,
            SceneError::OfJob(error) => Self::OfJob(error),
            other => Self::Scene(other),
        }
    }
}

impl From<IoError> for PrtError {
    /// Work that was stopped is [`PrtError::Cancelled`], wherever it was.
    fn from(error: IoError) -> Self {
        match error {
            IoError::Cancelled => Self::Cancelled,
            IoError::OfJob(error) => Self::OfJob(error),
            other => Self::Io(other),
        }
    }
}
