//! The tests of the crate from outside, in one program, which is linked once: files of scenes and rays among triangles.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;
#[cfg(feature = "compressed")]
mod compressed;
mod damaged_files;
mod far_coordinates;
mod finish;
mod hostile_files;
mod motion;
mod motion_built_in;
mod motion_faults;
mod motion_shapes;
mod motion_skins;
mod normal_maps;
mod obj_normals;
#[cfg(feature = "compressed")]
mod other_encoders;
mod outside;
mod ply_attributes;
mod posed_rays;
mod pruned;
mod rays;
mod read_gltf;
mod read_obj_ply;
mod read_posed;
mod split_edges;
mod subdivided;
mod textures;
mod unwrap;
mod write_gltf;
