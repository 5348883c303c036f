//! TODO room zonal.

pub(crate) mod bfgs;
pub(crate) mod lobes;
pub(crate) mod zonal_fit;
pub(crate) mod zonal_transfer;
