//! The tests of the crate from outside, in one program, which is linked once: maps, mappings, projection, filtering, area
//! lights, skies, and files.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod area_lights;
mod common;
mod cube_layouts;
mod engines;
mod files;
mod irradiance;
mod known_defects;
mod mappings;
mod prefilter;
mod projection;
mod resampled_energy;
mod resampled_suns;
mod resampling;
mod ringing;
mod scene_light;
mod skies;
mod sun;
