//! Unwrapping: texture coordinates of a lightmap for scenes that have none.
//!
//! `options` says how, `unwrap` does it. Uses `scene`.

pub(crate) mod options;
pub(crate) mod unwrap;
