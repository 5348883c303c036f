//! Rotations, reflections and exchanges of axes.
//!
//! Read [`rotation`] first; it turns bands 1 and 2 by [`low_bands`] and all others by [`zyz`], rotations about z
//! between exchanges of y and z ([`yz_exchange`], computed from Wigner's d-matrices of 90° in [`wigner_half_pi`]).
//! [`ivanic`] builds one matrix for each band, for many expansions. [`mirror`] and [`axis_permutation`] are exact. Uses
//! `basis`, `expansion` and `sphere`.

pub(crate) mod axis_permutation;
pub(crate) mod ivanic;
pub(crate) mod low_bands;
pub(crate) mod mirror;
pub(crate) mod rotation;
pub(crate) mod wigner_half_pi;
pub(crate) mod yz_exchange;
pub(crate) mod zyz;
