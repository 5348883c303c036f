//! TODO room mapping.

pub mod angular;
pub(crate) mod azimuthal;
pub mod cube;
pub mod dual_paraboloid;
pub mod equal_area;
pub(crate) mod interpolate;
pub mod lat_long;
pub(crate) mod mapping;
pub mod mirror_ball;
pub mod octahedral;
pub(crate) mod polygon;
pub(crate) mod solid_angles;
pub(crate) mod taps;
pub(crate) mod texel_quadrature;
