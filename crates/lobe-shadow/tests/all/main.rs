//! The tests of this crate through its public interface.

#![allow(clippy::unwrap_used, reason = "tests")]

mod field_bakes;
mod field_errors;
mod field_files;
mod radiance_fields;
mod shadow_fields;
mod shapes;
