//! TODO room light.

pub(crate) mod cone;
pub(crate) mod light;
pub(crate) mod normalization;
pub(crate) mod soft_cone;
pub(crate) mod spherical_polygon;
