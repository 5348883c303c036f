//! Exponentials and logarithms of functions on the sphere: a product of many functions as a sum of their logarithms.
//!
//! Read `logarithm` first, then `exponential`, which lists the methods. `matrix_function` is what both rest on,
//! `zonal_logarithm` the fast logarithm for tables of spheres, `batch_logarithm` that of many functions side by side,
//! `optimal_linear` the table of one method, `error_bound`
//! what is proven. Uses `basis`, `batch`, `expansion`, `product`, `simd`, `solver` and `sphere`.

#[cfg(feature = "batch")]
pub(crate) mod batch_logarithm;
mod error_bound;
pub(crate) mod exponential;
pub(crate) mod logarithm;
mod matrix_function;
pub(crate) mod optimal_linear;
pub(crate) mod zonal_logarithm;

#[cfg(feature = "batch")]
pub use batch_logarithm::logarithm_batch_in_place;
pub use exponential::{ExpMethod, Exponential};
pub use logarithm::{LOG_CLAMP, logarithm};
pub use optimal_linear::OptimalLinear;
pub use zonal_logarithm::ZonalLogarithm;
