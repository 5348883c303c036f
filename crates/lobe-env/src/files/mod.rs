//! Map files: readers of lat-long pictures ([`read_env`]), of cube maps ([`read_cube`], [`cube_faces`]) and of any map
//! ([`read_map`]), and the writers.
//!
//! Read first: [`read_options`], [`read_env`], [`read_map`]. Decoding and encoding belong to `lobe-image`; this room
//! interprets the attribute `envmap` of OpenEXR ([`exr_envmap`]). Uses map, mapping and resample.

pub mod bundled;
pub(crate) mod cube_faces;
pub(crate) mod exr_envmap;
pub(crate) mod read_cube;
pub(crate) mod read_env;
pub(crate) mod read_map;
pub(crate) mod read_options;
pub(crate) mod write;
pub(crate) mod write_cube;
