//! TODO room bake.

pub(crate) mod bake;
pub(crate) mod compress;
pub(crate) mod fit_lobes;
pub(crate) mod report;
pub(crate) mod split;
