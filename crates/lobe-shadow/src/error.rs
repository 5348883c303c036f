//! The error type of this crate.

use lobe_io::{IoError, OptionError};
use lobe_scene::SceneError;

/// An error of making, reading or writing what moves: a variant for each kind of fault.
///
/// Every message is one line: where, what was expected, what was found, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShadowError {
    /// The file or the data contradict themselves, are cut off, or hold something else.
    #[error("{place}: {message}")]
    Invalid {
        /// The file, or the name the caller gave to the data.
        place: String,
        /// What is wrong with it.
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

impl From<IoError> for ShadowError {
    /// Work that was stopped is [`ShadowError::Cancelled`], wherever it was.
    fn from(error: IoError) -> Self {
        match error {
            IoError::Cancelled => Self::Cancelled,
            IoError::OfJob(error) => Self::OfJob(error),
            other => Self::Io(other),
        }
    }
}

impl From<SceneError> for ShadowError {
    /// Work that was stopped is [`ShadowError::Cancelled`], wherever it was.
    fn from(error: SceneError) -> Self {
        match error {
            SceneError::Cancelled => Self::Cancelled,
            SceneError::OfJob(error) => Self::OfJob(error),
            other => Self::Scene(other),
        }
    }
}

impl ShadowError {
    /// The same fault, of this file.
    pub(crate) fn within(self, name: &str) -> Self {
        match self {
            Self::Invalid { message, .. } | Self::Options(message) => {
                Self::Invalid { place: name.to_owned(), message: message.replace(['\n', '\r'], " ") }
            }
            other => other,
        }
    }
}
