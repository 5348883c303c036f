//! TODO room sky.

pub(crate) mod cie_sky;
pub(crate) mod preetham;
pub(crate) mod sky;
pub(crate) mod sky_fit;
pub(crate) mod sun_extraction;
