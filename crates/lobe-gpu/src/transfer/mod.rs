//! Shading by precomputed radiance transfer on the device.
//!
//! Read `pieces`, which lays rows out for the device and splits what is too large for one binding, then `gpu_transfer`, which
//! shades matte receivers, `gpu_matrices`, which shades glossy ones, and `texture_transfer`, which does without compute shaders. Uses `lookup`, `renderer` and `context`.

pub(crate) mod gpu_matrices;
pub(crate) mod gpu_transfer;
pub(crate) mod pieces;
pub(crate) mod texture_transfer;
