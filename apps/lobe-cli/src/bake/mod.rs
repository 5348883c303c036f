//! Commands that make transfer: `lobe bake`, `lobe compress`, `lobe fit-lobes`.
//!
//! `bake` runs the library's job, `report` prints what came of it. `compress` and `fit_lobes` are commands of their
//! own. Uses `args` and `run`.

pub(crate) mod bake;
pub(crate) mod compress;
pub(crate) mod fit_lobes;
pub(crate) mod report;
