//! Paths in tables of options: text, in which what is no text is replaced.

use std::path::{Path, PathBuf};

use serde::{Serialize as _, Serializer};

/// Serializes a path as text. A name that is no text, as other systems make them, is shown as far as it is: the path
/// itself stays what it is.
///
/// # Errors
/// Those of the serializer.
pub fn as_text<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    path.to_string_lossy().serialize(serializer)
}

/// [`as_text`] of a path that may be missing.
///
/// # Errors
/// Those of the serializer.
pub fn as_text_if_any<S: Serializer>(path: &Option<PathBuf>, serializer: S) -> Result<S::Ok, S::Error> {
    path.as_ref().map(|path| path.to_string_lossy()).serialize(serializer)
}

/// [`as_text`] of each path of a list that may be missing.
///
/// # Errors
/// Those of the serializer.
pub fn as_texts<S: Serializer>(paths: &Option<Vec<PathBuf>>, serializer: S) -> Result<S::Ok, S::Error> {
    let texts = |paths: &Vec<PathBuf>| paths.iter().map(|path| path.to_string_lossy().into_owned()).collect::<Vec<_>>();
    paths.as_ref().map(texts).serialize(serializer)
}
