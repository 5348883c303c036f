//! The tests of the crate from outside, in one program, which is linked once.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod balls_in_solids;
mod shapes;
mod sphere_files;
mod sphere_fits;
mod sphere_skins;
mod sphere_trees;
