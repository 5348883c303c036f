//! Occluders that move, on the device, and vertices that joints carry.
//!
//! Read `gpu_sphere_shadows`, `gpu_shadow_fields` and `gpu_skin`; none uses another. Uses `lookup`, `renderer` and `context`.

pub(crate) mod gpu_shadow_fields;
pub(crate) mod gpu_skin;
pub(crate) mod gpu_sphere_shadows;
