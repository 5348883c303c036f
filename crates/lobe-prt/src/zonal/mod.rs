//! Zonal lobes: locally deformable transfer, whose lobes turn with the surface [Sloan 2005].
//!
//! Read `zonal_transfer` first, the result; then `zonal_fit`, the search, `lobes`, its linear least squares, and
//! `bfgs`, which moves the axes. Uses `compression`, `job` and `transfer`.

pub(crate) mod bfgs;
pub(crate) mod lobes;
pub(crate) mod zonal_fit;
pub(crate) mod zonal_transfer;
