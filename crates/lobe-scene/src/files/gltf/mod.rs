//! glTF reading and writing, in parts.
//!
//! Reading: `files` is a file with its buffers, of a `container`, of `uri`s, of the `extensions` it needs and of `root`,
//! the members that are used; `accessor` reads numbers; `nodes` places meshes, `placement`
//! finds the origin that they count from; `materials` reads colors and textures, `normal_maps` the tangents that belong to some;
//! `plain` is a file in which `meshopt`, `draco`, `instancing` and `flat`
//! have made plain what it stores otherwise, after `unfolded` has counted what it shows.
//! Writing: `document` is a file to extend, `from_scene` creates one; `subdivided` gives primitives of a file the
//! vertices of a split scene, with attributes of `middles`, around as `orientation` says; `pruned` takes out what
//! nothing names.

pub(crate) mod accessor;
pub(crate) mod component;
pub(crate) mod container;
pub(crate) mod document;
pub(crate) mod draco;
pub(crate) mod extensions;
pub(crate) mod files;
pub(crate) mod flat;
pub(crate) mod from_scene;
pub(crate) mod instancing;
pub(crate) mod materials;
#[cfg(feature = "compressed")]
pub(crate) mod meshopt;
pub(crate) mod middles;
pub(crate) mod nodes;
pub(crate) mod normal_maps;
pub(crate) mod orientation;
pub(crate) mod placement;
pub(crate) mod plain;
pub(crate) mod primitive;
pub(crate) mod pruned;
pub(crate) mod root;
pub(crate) mod smooth;
pub(crate) mod subdivided;
pub(crate) mod unfolded;
pub(crate) mod uri;
