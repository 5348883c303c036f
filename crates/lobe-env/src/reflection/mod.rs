//! TODO room reflection.

pub(crate) mod brdf;
pub(crate) mod dfg;
pub(crate) mod specular_lobe;
