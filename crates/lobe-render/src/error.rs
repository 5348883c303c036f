//! What can go wrong with a picture, by whose fault it is.

use std::path::PathBuf;

use lobe_image::ImageError;
use lobe_prt::PrtError;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The data do not make a picture.
    #[error("{0}")]
    Invalid(String),
    /// The caller asked for something that cannot be.
    #[error("{0}")]
    Options(String),
    /// A picture could not be made, read, written or compared.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A scene, its transfer or their files are at fault.
    #[error(transparent)]
    Prt(PrtError),
    /// The caller's progress function said to stop.
    #[error("stopped before the end")]
    Cancelled,
    /// A file could not be written.
    #[error("{}: cannot write the picture: {source}", path.display())]
    Io {
        /// The file that was to be written.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

impl From<PrtError> for RenderError {
    /// Work that was stopped is [`RenderError::Cancelled`], wherever it was.
    fn from(error: PrtError) -> Self {
        match error {
            PrtError::Cancelled => Self::Cancelled,
            other => Self::Prt(other),
        }
    }
}
