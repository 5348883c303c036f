//! Commands that make transfer: `lobe bake`, `lobe compress`, `lobe fit-lobes`.
//!
//! `options` has the options of `bake`, which does the work; `split` adds vertices before it, `texels` unwraps for a
//! lightmap, `backs` bakes the other sides after it, `report` prints the report.
//! `compress` and `fit_lobes` are commands of their own. Uses `args` and `run`.

mod backs;
pub(crate) mod bake;
pub(crate) mod compress;
pub(crate) mod fit_lobes;
pub(crate) mod options;
pub(crate) mod report;
pub(crate) mod split;
pub(crate) mod texels;
