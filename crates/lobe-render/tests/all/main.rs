//! The tests of the crate from outside, in one program, which is linked once: pictures against closed forms and against each other.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod baked_scene;
mod behind;
mod bent_normals;
mod emitters;
mod environment_mapping;
mod far;
mod glossy;
mod lamps;
mod mapped_scenes;
mod masks;
mod moving;
mod moving_parts;
mod moving_poses;
mod normal_maps;
mod part_files;
mod path_tracer;
mod png;
mod silhouettes;
mod strict;
