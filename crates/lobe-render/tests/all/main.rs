//! The tests of the crate from outside, in one program, which is linked once: pictures against closed forms and against each other.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod baked_scene;
mod behind;
mod bent_normals;
mod emitters;
mod far;
mod glossy;
mod gltf_surfaces;
mod mapped_scenes;
mod masks;
mod normal_maps;
mod path_tracer;
mod silhouettes;
mod strict;
mod suns;
