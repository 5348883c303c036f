//! Occluders that move, on the device.
//!
//! Read `gpu_moving_part`, a part of a moving scene with all that hides the sky from it, then the passes of which it consists in their
//! order: `sphere_passes` with `straight_line`, what is written out of their shaders, `still_grid`, `field_passes` with `field_parts`,
//! what they do where fields are large, `sky_light_passes`. `gpu_sphere_shadows` are spheres alone.
//! Uses `lookup`, `renderer` and `context`.

pub(crate) mod field_parts;
pub(crate) mod field_passes;
pub(crate) mod gpu_moving_part;
pub(crate) mod gpu_sphere_shadows;
pub(crate) mod receiver_shapes;
pub(crate) mod sky_light_passes;
pub(crate) mod sphere_passes;
pub(crate) mod still_grid;
pub(crate) mod straight_line;
