//! Occluders that move, on the device, and vertices that joints carry.
//!
//! Read `gpu_sphere_shadows` with `straight_line`, the part of its shaders that is written out, `gpu_shadow_fields` with `field_parts`, what it does where fields are large, and `gpu_skin`. Uses `lookup`, `renderer` and `context`.

pub(crate) mod field_parts;
pub(crate) mod gpu_shadow_fields;
pub(crate) mod gpu_skin;
pub(crate) mod gpu_sphere_shadows;
pub(crate) mod straight_line;
