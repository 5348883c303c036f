//! Reading of whole scenes, whatever their format, with what moves them at one time.
//!
//! Read `read_scene` first; then `gltf_reader`, an open file of glTF, and `posed`, the scene of such a file at a time;
//! last `scene_source`, a scene as a job names it, and `entity_source`, one entity of it. Uses `built_in`, `files`, `motion` and `scene`.

pub(crate) mod entity_source;
pub(crate) mod gltf_reader;
pub(crate) mod posed;
pub(crate) mod read_scene;
pub(crate) mod scene_source;
