//! The error type of this crate: what was drawn by built-in data, so that only files are at fault, or who watches.

use std::path::Path;

use lobe::env::EnvError;
use lobe::image::ImageError;
use lobe::io::IoError;
use lobe::prt::PrtError;
use lobe::render::RenderError;
use lobe::sh::ShError;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GalleryError {
    /// The caller asked for something that cannot be.
    #[error("{0}")]
    Options(String),
    /// The watch of the job said to stop.
    #[error("stopped before the end")]
    Cancelled,
    /// A file could not be written.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A picture could not be written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A map could not be made.
    #[error(transparent)]
    Env(#[from] EnvError),
    /// A scene could not be baked.
    #[error(transparent)]
    Prt(#[from] PrtError),
    /// A scene could not be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A light could not be made, or its file not be written.
    #[error(transparent)]
    Sh(#[from] ShError),
}

impl GalleryError {
    pub(crate) fn io(path: &Path) -> impl Fn(std::io::Error) -> Self {
        move |source| Self::Io(IoError::io(path, source))
    }
}

/// The result of drawing: all is on the page.
pub(crate) type Drawn = Result<(), GalleryError>;
