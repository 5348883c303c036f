//! Occluders that move, on the device, and vertices that joints carry.
//!
//! Read `gpu_sphere_shadows`, `gpu_shadow_fields` with `field_parts`, what it does where fields are large, and `gpu_skin`. Uses `lookup`, `renderer` and `context`.

pub(crate) mod field_parts;
pub(crate) mod gpu_shadow_fields;
pub(crate) mod gpu_skin;
pub(crate) mod gpu_sphere_shadows;
