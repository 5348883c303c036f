//! Projection of maps onto spherical harmonics, reconstruction, and irradiance.
//!
//! Read [`project`] first. A lat-long map, of numbers or of colors ([`lat_long_rows`]), is projected row by row: a Fourier transform along the row ([`row_dft`],
//! folded by symmetry in [`row_fold`]), exact integrals of Legendre functions across it ([`row_legendre`]). The inner
//! loops are in [`table_sums`]. Rows that come one after the other go to the [`lat_long_projector`]. Maps in other mappings are projected by
//! [`project_map`], those of planes through [`patch_moments`]. [`irradiance`] is the light on a Lambertian surface, by coefficients and by brute force
//! ([`horizon`]); [`encoding_errors`] compares its encodings. Uses `map` and `mapping`.

pub(crate) mod encoding_errors;
pub(crate) mod horizon;
pub(crate) mod irradiance;
pub(crate) mod lat_long_projector;
pub(crate) mod lat_long_rows;
pub(crate) mod patch_moments;
pub(crate) mod project;
pub(crate) mod project_map;
pub(crate) mod reconstruct;
pub(crate) mod row_dft;
pub(crate) mod row_fold;
pub(crate) mod row_legendre;
pub(crate) mod table_sums;
