//! TODO room filter.

pub(crate) mod convolve;
pub(crate) mod kernel;
pub(crate) mod window;
