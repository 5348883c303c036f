//! TODO room files.

pub(crate) mod read;
pub(crate) mod read_gltf;
pub(crate) mod read_obj;
pub(crate) mod read_ply;
