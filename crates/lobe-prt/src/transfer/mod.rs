//! Transfer, and light applied to it: vectors of matte receivers, matrices of glossy ones.
//!
//! Read `transfer` first, then `half_transfer`, the same in 16 bits, and `transfer_matrices`; `transfer_rows` reads both a few receivers at a time. `dot_rows`
//! applies a light to rows of either `number`, and `weighted_rows` to clusters, by the vector instructions of `simd`; `glossy_lobe` is what blurs the light of matrices. Uses `job`.

pub(crate) mod dot_rows;
pub(crate) mod glossy_lobe;
pub(crate) mod half_transfer;
pub(crate) mod number;
pub(crate) mod simd;
pub(crate) mod transfer;
pub(crate) mod transfer_matrices;
pub(crate) mod transfer_parts;
pub(crate) mod transfer_rows;
pub(crate) mod weighted_rows;
