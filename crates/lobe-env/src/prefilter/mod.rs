//! Prefiltered environment maps for glossy reflection: a map convolved with a lobe for each roughness.
//!
//! Read [`prefilter`] first, which opens with the derivation, and its [`options`], with the [`roughness_levels`] of
//! engines. [`gather`] integrates over a tree of cells ([`cell_tree`]), as coarse as [`cell_tolerance`] allows for the
//! [`brightness`] of each. Uses `map`, `mapping` and `reflection`.

pub(crate) mod brightness;
pub(crate) mod cell_tolerance;
pub(crate) mod cell_tree;
pub(crate) mod gather;
pub(crate) mod options;
pub(crate) mod prefilter;
pub(crate) mod roughness_levels;
