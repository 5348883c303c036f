//! TODO room sampling.

pub(crate) mod sobol;
pub(crate) mod warp;
