//! Solvers of small dense problems.
//!
//! [`nnls`] is non-negative least squares, [`ldp`] least distance programming on top of it; [`bfgs_on_sphere`] and
//! [`newton_on_sphere`] ascend to maxima of a function of direction. Uses `expansion` and `sphere`.

pub(crate) mod bfgs_on_sphere;
pub(crate) mod ldp;
pub(crate) mod newton_on_sphere;
pub(crate) mod nnls;
