//! Shading by precomputed radiance transfer on the device.
//!
//! Read `reflecting_transfer` and `vector_passes`, which shade matte receivers, `matrix_passes`, which shade glossy
//! ones, and `texture_transfer`, which does without compute shaders. Uses `lookup`, `renderer` and `context`.

pub(crate) mod matrix_passes;
pub(crate) mod reflecting_transfer;
pub(crate) mod texture_transfer;
pub(crate) mod vector_passes;
