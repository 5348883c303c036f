//! Compression of transfer by clustered principal component analysis (CPCA) of rows of numbers [Sloan 2003].
//!
//! Read `compress` first, the choice among solutions; then `cpca`, which clusters; `pca` finds the components of one
//! cluster by `eigen`, the symmetric eigenvalue problem; `nearest` finds the cluster of a row. `compressed_table` is
//! the result, `compressed_transfer` the same for transfer; `compression_options` is what a job asks for. Uses `job`, `sampling` and `transfer`.

pub(crate) mod compress;
pub(crate) mod compressed_table;
pub(crate) mod compressed_transfer;
pub(crate) mod compression_options;
pub(crate) mod cpca;
pub(crate) mod eigen;
pub(crate) mod nearest;
pub(crate) mod pca;
