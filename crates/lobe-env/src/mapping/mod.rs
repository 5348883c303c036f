//! From directions to places in a picture and back, one file for each way of unfolding the sphere.
//!
//! Read first: [`mapping`], which lists them, then [`lat_long`] and [`cube`]. [`azimuthal`] has what the discs have in
//! common, [`solid_angles`], [`texel_quadrature`] and [`polygon`] measure texels; [`taps`] numbers the texels of a
//! picture, and finds those that a direction is interpolated from, across every seam. Uses no other room.

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
