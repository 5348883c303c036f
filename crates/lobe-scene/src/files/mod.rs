//! Scene files: readers of glTF, OBJ and PLY, and a writer of glTF.
//!
//! Read `scene_format` first, the table of formats; then `source`, the input of every reader, which keeps the
//! limits and, by `folder`, to the folder; then `read_ply`, a file of its own, and `read_obj` and `read_gltf`, whose
//! parts are in the folders `obj` and `gltf`. `polygon` makes triangles of faces, `picture` textures of pictures, with
//! `jpeg_end` to see whether all is there. `built_without` stands in for decoders that a build leaves out. Uses `scene`.

#[cfg(any(test, not(feature = "compressed")))]
pub(crate) mod built_without;
pub(crate) mod folder;
pub(crate) mod gltf;
pub(crate) mod jpeg_end;
pub(crate) mod obj;
pub(crate) mod picture;
pub(crate) mod polygon;
pub(crate) mod read_gltf;
pub(crate) mod read_obj;
pub(crate) mod read_options;
pub(crate) mod read_ply;
pub(crate) mod scene_format;
pub(crate) mod source;
