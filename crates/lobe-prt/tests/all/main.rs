//! The tests of the crate from outside, in one program, which is linked once: bakes, their receivers, compression and files.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod adaptive;
mod bake;
mod baked_backs;
mod baked_elsewhere;
mod baked_glb;
mod checkpoint;
mod cloth;
mod common;
mod compression;
mod compression_of_bakes;
mod convex;
mod finishing;
mod glass;
mod masks;
mod matrices;
mod normal_maps;
mod texels;
mod vertex_fit;
mod watched;
mod zonal;
