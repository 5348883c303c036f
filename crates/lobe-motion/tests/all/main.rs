//! The tests of the crate from outside, in one program: moments of moving scenes against path traced ones, and files of parts.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod lamps;
mod moving;
mod moving_parts;
mod moving_poses;
mod part_files;
