//! Tables that are computed once and shared by the whole process.

/// A place for a value that the first caller computes and all others read.
pub(crate) struct Once<T> {
    #[cfg(feature = "std")]
    place: std::sync::OnceLock<T>,
    #[cfg(not(feature = "std"))]
    place: once_cell::race::OnceBox<T>,
}

impl<T> Once<T> {
    /// An empty place.
    pub(crate) const fn new() -> Self {
        Self {
            #[cfg(feature = "std")]
            place: std::sync::OnceLock::new(),
            #[cfg(not(feature = "std"))]
            place: once_cell::race::OnceBox::new(),
        }
    }

    /// The value, computed by `make` on the first call. Without the feature `std` callers cannot wait for each other:
    /// those that come at the same time may all compute it, and one of the equal results is kept.
    pub(crate) fn get_or_init(&self, make: impl FnOnce() -> T) -> &T {
        #[cfg(feature = "std")]
        return self.place.get_or_init(make);
        #[cfg(not(feature = "std"))]
        return self.place.get_or_init(|| alloc::boxed::Box::new(make()));
    }
}
