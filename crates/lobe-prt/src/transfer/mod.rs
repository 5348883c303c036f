//! TODO room transfer.

pub(crate) mod dot_rows;
pub(crate) mod simd4;
pub(crate) mod transfer;
pub(crate) mod transfer_matrices;
pub(crate) mod transfer_rows;
