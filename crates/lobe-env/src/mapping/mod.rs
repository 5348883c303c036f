//! Mappings between directions and points of a picture: lat-long, cube, octahedral, mirror ball and others.
//!
//! Read [`mapping`] first, which lists them, then [`lat_long`] and [`cube`]. [`azimuthal`] is shared by the round
//! pictures, among them those of [`fisheye`] lenses; [`solid_angles`], [`texel_quadrature`] and [`polygon`] measure
//! texels; [`taps`] indexes the texels of a picture, and finds the taps of bilinear interpolation across every seam. Uses no other room.

pub mod angular;
pub(crate) mod azimuthal;
pub mod cube;
pub mod dual_paraboloid;
pub mod equal_area;
pub(crate) mod fisheye;
pub mod lat_long;
pub(crate) mod mapping;
pub mod mirror_ball;
pub mod octahedral;
pub(crate) mod polygon;
pub(crate) mod solid_angles;
pub(crate) mod taps;
pub(crate) mod texel_quadrature;
