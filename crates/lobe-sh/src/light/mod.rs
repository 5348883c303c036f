//! TODO

pub(crate) mod cone;
pub(crate) mod light;
pub(crate) mod normalization;
pub(crate) mod spherical_polygon;
