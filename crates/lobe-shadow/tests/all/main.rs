//! The tests of the crate from outside, in one program, which is linked once.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod accumulate;
mod log_table;
mod sphere_bounce;
