//! Scenes in motion: animations, skins and morph targets, and scenes posed by them.
//!
//! Read `animated_scene` first, and `posed_scene`, what it gives at a time, with `entity` and `place`; then `rig`, the nodes,
//! and `animation`, which moves them by `sampler`s, and `similar_nodes`, those that keep their shape; then `shape` and `skin`,
//! the vertices and what carries them. `read` makes all this of glTF files: `read_animations` with `read_samplers`,
//! `read_skins`, `read_shapes`, which get their numbers from `numbers`. `split_poses` splits edges
//! in all poses, and `morphs` has the shapes of an entity at any weights of its morph targets. Uses `files`, `bvh` and
//! `scene`.

pub(crate) mod animated_scene;
pub(crate) mod animation;
pub(crate) mod entity;
mod morphs;
pub(crate) mod numbers;
pub(crate) mod place;
pub(crate) mod posed_scene;
pub(crate) mod read;
pub(crate) mod read_animations;
pub(crate) mod read_samplers;
pub(crate) mod read_shapes;
pub(crate) mod read_skins;
pub(crate) mod rig;
pub(crate) mod sampler;
pub(crate) mod shape;
pub(crate) mod similar_nodes;
pub(crate) mod skin;
pub(crate) mod split_poses;
