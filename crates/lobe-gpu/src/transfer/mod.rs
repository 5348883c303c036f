//! Shading by precomputed radiance transfer on the device.
//!
//! Read `gpu_transfer`, which shades matte receivers, `gpu_matrices`, which shades glossy ones, and `texture_transfer`, which does without compute shaders. Uses `lookup`, `renderer` and `context`.

pub(crate) mod gpu_matrices;
pub(crate) mod gpu_transfer;
pub(crate) mod texture_transfer;
