//! The room of skies: an environment, its mappings, and what is left of it in an expansion.
//!
//! Read `edits`, then `findings`, what the library says of the expansion, `panels`, the pictures, and `sky_room`.

pub(crate) mod edits;
pub(crate) mod findings;
pub(crate) mod panels;
pub(crate) mod sky_room;
