//! The parts of reading and making glTF.
//!
//! Reading: `files` unpacks .glb, data URIs and files beside it; `accessor` reads numbers; `nodes` places meshes; `materials` reads
//! colors and textures; `attributes` keeps what a bake has added. Writing: `document` is a file to add to, `from_scene` makes one.

pub(crate) mod accessor;
pub(crate) mod attributes;
pub(crate) mod document;
pub(crate) mod files;
pub(crate) mod from_scene;
pub(crate) mod materials;
pub(crate) mod nodes;
