//! The error of the crate.

/// Why a shader cannot be written.
///
/// Every message is one line: what was expected, what was found, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShaderError {
    /// A name is none of those that exist, or a language has no text.
    #[error("{0}")]
    Options(String),
}
