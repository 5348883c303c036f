//! Solvers of small dense problems.
//!
//! [`matrix`] is a matrix, [`cholesky`], [`householder`] (the triangular factor), [`singular_values`] and [`symmetric_eigen`] are its
//! factorizations. [`nnls`] is non-negative least squares, [`ldp`] least distance programming on top of it; [`bfgs_on_sphere`] and
//! [`newton_on_sphere`] ascend to maxima of a function of direction. Uses `expansion` and `sphere`.

pub(crate) mod bfgs_on_sphere;
pub(crate) mod cholesky;
pub(crate) mod householder;
pub(crate) mod ldp;
pub(crate) mod matrix;
pub(crate) mod newton_on_sphere;
pub(crate) mod nnls;
pub(crate) mod singular_values;
pub(crate) mod symmetric_eigen;
