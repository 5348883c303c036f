//! TODO room path_tracer.

pub(crate) mod bsdf;
pub(crate) mod distant_light;
pub(crate) mod estimate;
pub(crate) mod ggx;
pub(crate) mod path_tracer;
pub(crate) mod pixel;
pub(crate) mod reference;
pub(crate) mod sampler;
pub(crate) mod sphere_table;
pub(crate) mod truth_checkpoint;
pub(crate) mod truth_exr;
