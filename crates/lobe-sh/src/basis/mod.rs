//! The real spherical-harmonic basis: numbering, values and derivatives.
//!
//! Read [`index`] first, then [`basis`] with the recurrence that everything rests on. [`legendre`] and [`complex`] are
//! the textbook functions; [`second_order`] adds slopes and curvatures. Uses `sphere`.

pub(crate) mod basis;
pub(crate) mod complex;
pub(crate) mod index;
pub(crate) mod legendre;
pub(crate) mod second_order;
