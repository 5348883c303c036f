//! The tests of the crate from outside, in one program, which is linked once.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod accumulate;
mod balls_in_solids;
mod field_bakes;
mod field_errors;
mod field_files;
mod horizon;
mod lamp_files;
mod log_table;
mod many_spheres;
mod mutated_files;
mod radiance_fields;
mod shadow_fields;
mod shapes;
mod shares;
mod solids;
mod sphere_bounce;
mod sphere_entities;
mod sphere_files;
mod sphere_fits;
mod sphere_skins;
mod visibility_files;
