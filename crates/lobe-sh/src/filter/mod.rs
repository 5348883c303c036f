//! One factor for each band: convolution kernels and windows.
//!
//! Read [`kernel`] first (convolution; clamped cosine, Phong, GGX), then [`window`] (Hanning, Lanczos, Gauss and
//! the like). Uses `basis`, `expansion` and `sphere`.

pub(crate) mod kernel;
pub(crate) mod window;
