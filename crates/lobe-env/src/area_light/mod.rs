//! TODO room area_light.

pub(crate) mod area_light;
pub(crate) mod disc_light;
pub(crate) mod polygon_light;
pub(crate) mod sphere_light;
pub(crate) mod vector_irradiance;
