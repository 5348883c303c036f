//! Rotations, reflections and exchanges of axes.
//!
//! Read [`rotation`] first; it turns coefficients by [`zyz`]: bands 1 and 2 in closed form and all others by rotations
//! about z between exchanges of y and z ([`yz_exchange`], computed from Wigner's d-matrices of 90°). [`ivanic`] builds
//! one matrix for each band, for many expansions. [`axis_permutation`] is exact. Uses `basis`, `expansion` and `sphere`.

pub(crate) mod axis_permutation;
pub(crate) mod ivanic;
pub(crate) mod rotation;
pub(crate) mod yz_exchange;
pub(crate) mod zyz;
