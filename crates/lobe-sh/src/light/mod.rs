//! Analytic lights as expansions.
//!
//! Read `light` first. `cone` and `spherical_polygon` have the shapes in closed form, `normalization` what the
//! color of a light means. Uses `basis`, `expansion`, `rotation` and `sphere`.

pub(crate) mod cone;
pub(crate) mod light;
pub(crate) mod normalization;
pub(crate) mod spherical_polygon;

pub use light::Light;
pub use normalization::{Normalization, directional_normalization};
pub use spherical_polygon::SphericalPolygon;
