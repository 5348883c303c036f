//! TODO room projection.

pub(crate) mod horizon;
pub(crate) mod irradiance;
pub(crate) mod project;
pub(crate) mod project_map;
pub(crate) mod reconstruct;
pub(crate) mod row_dft;
pub(crate) mod row_legendre;
