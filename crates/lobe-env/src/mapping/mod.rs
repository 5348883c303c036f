//! Mappings between directions and points of a picture: lat-long, cube, octahedral, mirror ball and others.
//!
//! Read [`mapping`] first, the table of all, and [`form`], what a mapping is; then [`lat_long`] and [`cube`]. One more
//! mapping is a file and an entry in that table. [`discs`] and [`azimuthal`] are shared by the round pictures, among
//! them those of [`fisheye`] lenses; [`solid_angles`], [`texel_quadrature`] and [`polygon`] measure texels; [`grid`]
//! indexes the texels of a picture, and finds the [`taps`] of bilinear interpolation across every seam; [`fast_atan`]
//! is for pictures of angles. Uses no other room.

pub mod angular;
pub(crate) mod azimuthal;
pub mod cube;
pub(crate) mod discs;
pub mod dual_paraboloid;
pub mod equal_area;
pub(crate) mod fast_atan;
pub(crate) mod fisheye;
pub(crate) mod form;
pub(crate) mod grid;
pub mod lat_long;
pub(crate) mod mapping;
pub mod mirror_ball;
pub mod octahedral;
pub(crate) mod polygon;
pub(crate) mod solid_angles;
pub(crate) mod taps;
pub(crate) mod texel_quadrature;
