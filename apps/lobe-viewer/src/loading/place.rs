//! The place where the viewer runs, and the files that a page was given.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Whether it runs in a page of a browser: with one thread, without files of a user, and without waiting for the device.
pub(crate) const IN_PAGE: bool = cfg!(target_arch = "wasm32");

/// Files by the names under which they are opened.
static GIVEN: Mutex<BTreeMap<PathBuf, Arc<[u8]>>> = Mutex::new(BTreeMap::new());

/// Gives the bytes of a file to whoever opens this name; they come before a file of the system. A page has no others.
#[cfg(target_arch = "wasm32")]
pub(crate) fn give_file(name: impl Into<PathBuf>, bytes: Vec<u8>) {
    GIVEN.lock().unwrap_or_else(PoisonError::into_inner).insert(name.into(), bytes.into());
}

/// The bytes that were given under a name.
pub(crate) fn given(name: &Path) -> Option<Arc<[u8]>> {
    GIVEN.lock().unwrap_or_else(PoisonError::into_inner).get(name).cloned()
}
