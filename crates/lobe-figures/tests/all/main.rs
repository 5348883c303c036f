//! The tests of the crate from outside, in one program: techniques of environment mapping against their references.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod environment_mapping;
mod png;
