//! Sphere sets: few spheres that stand for a solid.
//!
//! Read `solid` first: what is inside a mesh, and how much of that in a ball, by the tree of `patch_tree`, at whose
//! leaves `far_part` cuts triangles with balls, less what `overlaps` count twice. `cover_samples` are the points to
//! cover. `ball` fits one sphere; `variational` many, in rounds that end with `teleport`; `medial_axis` is the other
//! way. `fit_spheres` has options, reports and the job. The result is a `sphere_set`, which may move with a `skin`;
//! `pose` binds and moves it, by `near_triangle`. `follow_entity` does so for an entity of an animated scene, whose joints its
//! `skeleton` names, with its `morphs`, which `follow_morphs` finds. `sphere_file` and `sphere_json` are its files,
//! `union_volume` what it fills, and `silhouette` makes it no larger than its shape. Uses no other room.

pub(crate) mod ball;
pub(crate) mod cover_samples;
pub(crate) mod far_part;
pub(crate) mod fit_spheres;
pub(crate) mod follow_entity;
mod follow_morphs;
pub(crate) mod medial_axis;
pub(crate) mod morphs;
pub(crate) mod near_triangle;
pub(crate) mod overlaps;
pub(crate) mod patch_tree;
pub(crate) mod pose;
mod silhouette;
pub(crate) mod skeleton;
pub(crate) mod skin;
pub(crate) mod solid;
pub(crate) mod sphere_file;
pub(crate) mod sphere_json;
pub(crate) mod sphere_set;
pub(crate) mod teleport;
pub(crate) mod union_volume;
pub(crate) mod variational;
