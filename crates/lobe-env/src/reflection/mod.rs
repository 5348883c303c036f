//! Reflectance: models ([`brdf`]), their lobes ([`specular_lobe`]), and their reflectance in uniform light ([`dfg`]),
//! the second factor of the split-sum approximation.
//!
//! Read [`brdf`] first. Uses no other room.

pub(crate) mod brdf;
pub(crate) mod dfg;
pub(crate) mod specular_lobe;
