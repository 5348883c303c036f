//! TODO room compression.

pub(crate) mod compress;
pub(crate) mod compressed_table;
pub(crate) mod compressed_transfer;
pub(crate) mod cpca;
pub(crate) mod eigen;
pub(crate) mod nearest;
pub(crate) mod pca;
