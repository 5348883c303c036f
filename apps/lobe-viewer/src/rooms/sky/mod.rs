//! The room of skies: an environment, its mappings, and what is left of it in an expansion.
//!
//! Read `edits`, then `findings`, what the library says of the expansion, `suns`, what is taken out, `surfaces`, what balls are made of, and
//! `techniques`, how they are shaded, then the pictures: `stage`, the sky itself, `panels`, maps, and `balls`, and `sky_room`.

pub(crate) mod balls;
pub(crate) mod edits;
pub(crate) mod findings;
pub(crate) mod panels;
pub(crate) mod sky_room;
pub(crate) mod stage;
pub(crate) mod suns;
pub(crate) mod surfaces;
pub(crate) mod techniques;
