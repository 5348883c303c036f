//! One factor for each band: convolution kernels and windows.
//!
//! Read `kernel` first (convolution; clamped cosine, Phong, GGX), then `window` (Hanning, Lanczos, Gauss and
//! the like) and `squared_laplacian`, which decides one of them. Uses `basis`, `expansion` and `sphere`.

pub(crate) mod kernel;
pub(crate) mod squared_laplacian;
pub(crate) mod window;

pub use kernel::convolve_in_place;
pub use squared_laplacian::{squared_laplacian, squared_laplacian_lambda};
pub use window::{Window, scale_bands_in_place, width_of_peak, window_in_place};
