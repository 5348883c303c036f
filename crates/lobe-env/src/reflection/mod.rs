//! Reflectance: models ([`brdf`]), their lobes ([`specular_lobe`]), their reflectance in uniform light ([`dfg`]), the
//! second factor of the split-sum approximation, and a table of it and of where lobes point ([`lobe_table`]), and how
//! they blur expansions ([`lobe_factors`]).
//!
//! Read [`brdf`] first. Uses no other room.

pub(crate) mod brdf;
pub(crate) mod dfg;
pub(crate) mod lobe_factors;
pub(crate) mod lobe_table;
pub(crate) mod specular_lobe;
