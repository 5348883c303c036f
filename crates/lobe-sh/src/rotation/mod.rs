//! Rotations, reflections and exchanges of axes.
//!
//! Read [`rotation`] first; it turns coefficients by [`zyz`]: bands 1 and 2 in closed form and all others by rotations
//! about z between exchanges of y and z ([`yz_exchange`], computed from Wigner's d-matrices of 90°), bands 3 to 7 by
//! straight-line code ([`middle_bands`]; [`generated`], written by `cargo xtask tables`). [`ivanic`] builds
//! one matrix for each band, for many expansions; [`lane_rotation`] applies them to sixteen at once. [`axis_permutation`] is
//! exact. Uses `basis`, `expansion`, `simd` and `sphere`.

pub(crate) mod axis_permutation;
pub(crate) mod cos_sin;
pub(crate) mod generated;
pub(crate) mod ivanic;
pub(crate) mod lane_rotation;
pub(crate) mod middle_bands;
pub(crate) mod rotation;
pub(crate) mod yz_exchange;
pub(crate) mod zyz;
