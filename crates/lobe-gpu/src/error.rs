//! Error type of this crate.

/// Errors of shading on a graphics device, by fault.
///
/// Every message is one line: where, what was expected, what was found, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter of this machine fits the options; a program falls back to `lobe-render`.
    #[error("no graphics adapter: {0}")]
    NoAdapter(String),
    /// The device lacks what the work needs.
    #[error("{place}: {message}")]
    Unsupported {
        /// The adapter or the pass.
        place: String,
        /// What is missing.
        message: String,
    },
    /// The device was lost, is out of memory or refused the work. After a loss everything on it is gone: make a new
    /// [`Context`](crate::Context) and upload again.
    #[error("{place}: {message}")]
    Device {
        /// The adapter or the pass.
        place: String,
        /// What the device says.
        message: String,
    },
    /// The caller asked for something that cannot be.
    #[error("{0}")]
    Options(String),
    /// The watch of a job said to stop.
    #[error("stopped before the end")]
    Cancelled,
    /// A picture could not be made or written.
    #[error(transparent)]
    Image(#[from] lobe_image::ImageError),
    /// A light could not be prefiltered.
    #[error(transparent)]
    Env(#[from] lobe_env::EnvError),
}

impl GpuError {
    pub(crate) fn device(place: impl Into<String>, message: impl std::fmt::Display) -> Self {
        // Messages of devices have several lines, from the outermost cause to the innermost.
        let message = message.to_string();
        let line = message.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(": ");
        Self::Device { place: place.into(), message: line }
    }
}
