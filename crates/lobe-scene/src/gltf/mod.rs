//! TODO room gltf.

pub(crate) mod accessor;
pub(crate) mod attributes;
pub(crate) mod document;
pub(crate) mod files;
pub(crate) mod from_scene;
pub(crate) mod materials;
pub(crate) mod nodes;
