//! The real spherical-harmonic basis: numbering, values and derivatives.
//!
//! Read `index` first, then `basis` with the formula that everything rests on, and its `recurrence`; `eval_many` evaluates many directions. `legendre` and `complex` are
//! the textbook functions; `second_order` adds slopes and curvatures. `lane_basis` evaluates registers of directions at once by
//! straight-line code (`lanes`, written by `cargo xtask tables`), or by the recurrence (`lane_recurrence`), `lane_rows` into rows of a tile and `lane_planes` into planes
//! of all directions; `lane_sums` sums one function towards them. `lane_kernels` has these for `f32` and `f64`. `vectors` become unit vectors. Uses `simd` and `sphere`.

pub(crate) mod basis;
pub(crate) mod complex;
pub(crate) mod eval_many;
pub(crate) mod index;
#[cfg(feature = "simd")]
pub(crate) mod lane_basis;
#[cfg(feature = "simd")]
pub(crate) mod lane_kernels;
#[cfg(feature = "simd")]
pub(crate) mod lane_planes;
#[cfg(feature = "simd")]
pub(crate) mod lane_recurrence;
#[cfg(feature = "simd")]
pub(crate) mod lane_rows;
#[cfg(feature = "simd")]
pub(crate) mod lane_sums;
#[cfg(feature = "simd")]
pub(crate) mod lanes;
pub(crate) mod legendre;
#[cfg(feature = "simd")]
pub(crate) mod places;
pub(crate) mod recurrence;
pub(crate) mod second_order;
#[cfg(feature = "simd")]
pub(crate) mod vectors;

pub use basis::{Basis, eval_basis, eval_basis_into};
pub use complex::{complex_from_real, eval_complex, real_from_complex};
pub use index::{MAX_ORDER, band_and_m, band_range, coefficient_count, coefficient_index, order_of};
pub use legendre::{legendre, legendre_normalized};
#[cfg(feature = "simd")]
pub use vectors::Vectors;
