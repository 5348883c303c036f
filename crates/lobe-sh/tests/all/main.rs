//! The tests of the crate from outside, in one program, which is linked once: expansions, products, rotations, ringing and encodings.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod content_window;
mod dering;
mod dering_table;
mod encodings;
mod exponential;
mod lights_out;
mod logarithm;
mod minimum;
mod products;
mod properties;
mod published;
mod rotation;
#[cfg(feature = "json")]
mod sh_json;
mod spherical_polygon;
mod windows;
