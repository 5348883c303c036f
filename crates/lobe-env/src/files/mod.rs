//! Map files: readers of lat-long pictures ([`read_env`]), of cube maps ([`read_cube`], [`cube_faces`]) and of any map
//! ([`read_map`]), and the writers.
//!
//! Read [`read_options`] first, then [`read_env`] and [`read_map`]. Decoding and encoding belong to `lobe-image`; this room
//! interprets the attribute `envmap` of OpenEXR ([`exr_envmap`]). Uses `map` and `mapping`.

pub mod bundled;
pub(crate) mod cube_faces;
pub(crate) mod exr_envmap;
pub(crate) mod read_cube;
pub(crate) mod read_env;
pub(crate) mod read_map;
pub(crate) mod read_options;
pub(crate) mod write;
pub(crate) mod write_cube;
