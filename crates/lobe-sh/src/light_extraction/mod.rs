//! Directional lights found in an expansion.
//!
//! Read [`extract`] first. It finds local maxima ([`peaks`]), solves for intensities ([`light_fit`]) and may improve
//! both together ([`refine`], Levenberg-Marquardt). Uses `solver`, `light`, `expansion` and what stands below them.

pub(crate) mod extract;
pub(crate) mod light_fit;
pub(crate) mod peaks;
pub(crate) mod refine;
