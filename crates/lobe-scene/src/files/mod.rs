//! Scene files: readers of glTF, OBJ and PLY, and a writer of glTF.
//!
//! Read `read` first, which chooses by the extension; then `source`, the input of every reader, which keeps the limits;
//! then `read_obj` and `read_ply`, a file each, and `read_gltf`, whose parts are in the folder `gltf`. Uses `scene`.

pub(crate) mod gltf;
pub(crate) mod read;
pub(crate) mod read_gltf;
pub(crate) mod read_obj;
pub(crate) mod read_options;
pub(crate) mod read_ply;
pub(crate) mod source;
