//! TODO room solver.

pub(crate) mod bfgs_on_sphere;
pub(crate) mod ldp;
pub(crate) mod newton_on_sphere;
pub(crate) mod nnls;
