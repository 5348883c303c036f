//! `lobe env`: commands on environment maps, a file each. Uses `args` and `run`.

pub(crate) mod adjust;
pub(crate) mod ambient;
pub(crate) mod area_light;
pub(crate) mod convert;
pub(crate) mod dfg;
pub(crate) mod info;
pub(crate) mod irradiance;
pub(crate) mod prefilter;
pub(crate) mod reconstruct;
pub(crate) mod rotate;
pub(crate) mod show;
pub(crate) mod sky;
pub(crate) mod sun;
pub(crate) mod vector_irradiance;
