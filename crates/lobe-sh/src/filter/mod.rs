//! One factor for each band: convolution kernels and windows.
//!
//! Read [`convolve`] first, then [`kernel`] (clamped cosine, Phong, GGX) and [`window`] (Hanning, Lanczos, Gauss and
//! the like). Uses `basis`, `expansion` and `sphere`.

pub(crate) mod convolve;
pub(crate) mod kernel;
pub(crate) mod window;
