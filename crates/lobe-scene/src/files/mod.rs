//! Scenes from files: glTF, OBJ and PLY, and glTF files made of scenes.
//!
//! Read `read` first, which chooses by the name; then `source`, which every reader reads from and which keeps the limits; then
//! `read_obj` and `read_ply`, a file each, and `read_gltf`, whose parts are in the folder `gltf`. May use the scene.

pub(crate) mod gltf;
pub(crate) mod read;
pub(crate) mod read_gltf;
pub(crate) mod read_obj;
pub(crate) mod read_options;
pub(crate) mod read_ply;
pub(crate) mod source;
