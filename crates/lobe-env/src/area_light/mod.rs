//! Area lights (spheres, discs and polygons), and the vector irradiance of a map.
//!
//! Read [`area_light`], the trait, first. Uses `map`, `mapping` and `projection`.

pub(crate) mod area_light;
pub(crate) mod disc_light;
pub(crate) mod polygon_light;
pub(crate) mod sphere_light;
pub(crate) mod vector_irradiance;
