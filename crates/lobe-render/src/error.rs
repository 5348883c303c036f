//! The error type of this crate: a variant for each kind of fault.

use std::path::Path;

use lobe_env::EnvError;
use lobe_image::ImageError;
use lobe_io::{IoError, OptionError};
use lobe_prt::PrtError;
use lobe_scene::SceneError;
use lobe_shadow::ShadowError;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A file or the data contradict themselves, or each other.
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
    /// A picture could not be made, read, written or compared.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The maps of a light could not be made.
    #[error(transparent)]
    Env(EnvError),
    /// What moves, or its files, are at fault.
    #[error(transparent)]
    Shadow(ShadowError),
    /// A scene is at fault.
    #[error(transparent)]
    Scene(SceneError),
    /// A scene, its transfer or their files are at fault.
    #[error(transparent)]
    Prt(PrtError),
    /// An option of a job is refused.
    #[error(transparent)]
    OfJob(#[from] OptionError),
    /// The watch of the job said to stop.
    #[error("stopped before the end")]
    Cancelled,
    /// An error at work on one part of a scene.
    #[error("part `{name}`: {source}")]
    Part {
        /// The name of the part.
        name: String,
        /// What was wrong.
        source: Box<Self>,
    },
    /// A file could not be read or written, or what is kept in one is at fault.
    #[error(transparent)]
    Io(IoError),
}

impl RenderError {
    pub(crate) fn io(path: &Path) -> impl Fn(std::io::Error) -> Self {
        move |source| Self::Io(IoError::io(path, source))
    }

    /// The same error at work on a part of a scene; being stopped is nobody's fault.
    #[must_use]
    pub fn of_part(self, name: &str) -> Self {
        match self {
            Self::Cancelled => Self::Cancelled,
            other => Self::Part { name: name.to_owned(), source: Box::new(other) },
        }
    }

    /// A contradiction in the file at `place`.
    pub fn invalid(place: &Path, message: impl Into<String>) -> Self {
        Self::Invalid { place: place.display().to_string(), message: message.into() }
    }
}

impl From<EnvError> for RenderError {
    /// Work that was stopped is [`RenderError::Cancelled`], wherever it was.
    fn from(error: EnvError) -> Self {
        match error {
            EnvError::Cancelled => Self::Cancelled,
            other => Self::Env(other),
        }
    }
}

impl From<SceneError> for RenderError {
    /// Work that was stopped is [`RenderError::Cancelled`], wherever it was.
    fn from(error: SceneError) -> Self {
        match error {
            SceneError::Cancelled => Self::Cancelled,
            SceneError::OfJob(error) => Self::OfJob(error),
            other => Self::Scene(other),
        }
    }
}

impl From<IoError> for RenderError {
    /// Work that was stopped is [`RenderError::Cancelled`], wherever it was.
    fn from(error: IoError) -> Self {
        match error {
            IoError::Cancelled => Self::Cancelled,
            IoError::OfJob(error) => Self::OfJob(error),
            other => Self::Io(other),
        }
    }
}

impl From<PrtError> for RenderError {
    /// Work that was stopped is [`RenderError::Cancelled`], wherever it was.
    fn from(error: PrtError) -> Self {
        match error {
            PrtError::Cancelled => Self::Cancelled,
            PrtError::OfJob(error) => Self::OfJob(error),
            other => Self::Prt(other),
        }
    }
}

impl From<ShadowError> for RenderError {
    /// Work that was stopped is [`RenderError::Cancelled`], wherever it was.
    fn from(error: ShadowError) -> Self {
        match error {
            ShadowError::Cancelled => Self::Cancelled,
            ShadowError::OfJob(error) => Self::OfJob(error),
            other => Self::Shadow(other),
        }
    }
}
