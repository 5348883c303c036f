//! The real spherical-harmonic basis: numbering, values and derivatives.
//!
//! Read [`index`] first, then [`basis`] with the recurrence that everything rests on, of which [`constants`] are the numbers. [`legendre`] and [`complex`] are
//! the textbook functions; [`second_order`] adds slopes and curvatures. [`lane_basis`] evaluates registers of directions at once by
//! straight-line code ([`lanes`], written by `cargo xtask tables`), or by the recurrence ([`lane_recurrence`]). Uses `simd` and `sphere`.

pub(crate) mod basis;
pub(crate) mod complex;
pub(crate) mod constants;
pub(crate) mod index;
#[cfg(feature = "std")]
pub(crate) mod lane_basis;
#[cfg(feature = "std")]
pub(crate) mod lane_recurrence;
#[cfg(feature = "std")]
pub(crate) mod lanes;
pub(crate) mod legendre;
#[cfg(feature = "std")]
pub(crate) mod places;
pub(crate) mod second_order;
