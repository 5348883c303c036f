//! TODO

pub(crate) mod ahd;
pub(crate) mod ambient_cube;
pub(crate) mod h_basis;
pub(crate) mod hemisphere;
pub(crate) mod hl2;
pub(crate) mod irradiance_bands;
pub(crate) mod irradiance_encoding;
pub(crate) mod irradiance_matrix;
pub(crate) mod non_linear_l1;
pub(crate) mod packed_irradiance;
pub(crate) mod zh3;
