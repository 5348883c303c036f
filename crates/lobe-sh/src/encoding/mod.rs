//! Irradiance in fewer numbers than the nine of order 3 for each channel, or in a form that suits shaders.
//!
//! Read [`irradiance_encoding`] first: it lists all encodings, to loop over, and measures their errors. Every encoding
//! is made from the expansion of the irradiance `E` (radiance convolved with the clamped cosine, not divided by π) and
//! gives `E` back for a normal; bands that the expansion lacks count as zero. [`packed_irradiance`] and
//! [`irradiance_matrix`] are order 3 rearranged; all others are approximations. [`irradiance_bands`] reads the low
//! bands for them. Uses `expansion`, `filter`, `projection`, `rotation`, `solver` and `sphere`.

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
