//! TODO room files.

pub mod bundled;
pub(crate) mod cube_faces;
pub(crate) mod exr_envmap;
pub(crate) mod read;
pub(crate) mod read_cube;
pub(crate) mod write;
pub(crate) mod write_cube;
