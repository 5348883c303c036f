//! Tables that are computed once and shared by the whole process.

use std::sync::OnceLock;

/// A place for a value that the first caller computes and all others read.
pub(crate) struct Once<T>(OnceLock<T>);

impl<T> Once<T> {
    /// An empty place.
    pub(crate) const fn new() -> Self {
        Self(OnceLock::new())
    }

    /// The value, computed by `make` on the first call.
    pub(crate) fn get_or_init(&self, make: impl FnOnce() -> T) -> &T {
        self.0.get_or_init(make)
    }
}
