//! glTF reading and writing, in parts.
//!
//! Reading: `files` opens .glb, data URIs and files beside it; `accessor` reads numbers; `nodes` places meshes,
//! `placement` finds the origin they count from;
//! `materials` reads colors and textures; `attributes` keeps the results of a bake. Writing: `document` is a file to
//! extend, `from_scene` creates one.

pub(crate) mod accessor;
pub(crate) mod attributes;
pub(crate) mod document;
pub(crate) mod files;
pub(crate) mod from_scene;
pub(crate) mod materials;
pub(crate) mod nodes;
pub(crate) mod placement;
