//! Many functions or directions at once, sixteen side by side.
//!
//! Read `sh_batch` first, the layout and what is computed in it; `dir_batch` has the directions, and
//! `basis_blocks` the basis towards them, and `lane_eval` functions towards one each. `values` evaluates functions that lie one after the other. The other kernels lie in the rooms of their mathematics. Uses `product`, `rotation`, `expansion`, `basis`, `simd` and `sphere`.

pub(crate) mod basis_blocks;
pub(crate) mod dir_batch;
pub(crate) mod lane_eval;
pub(crate) mod sh_batch;
#[cfg(feature = "simd")]
pub(crate) mod values;

#[cfg(feature = "batch")]
pub use dir_batch::DirBatch;
#[cfg(feature = "batch")]
pub use sh_batch::ShBatch;
#[cfg(feature = "simd")]
pub use values::{BasisTiles, Functions, Tiled};
