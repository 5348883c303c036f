//! Map files: what a file says of its mapping, and the same map through every format.
#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

#[path = "../common/mod.rs"]
mod common;
mod envmap;
mod maps;
