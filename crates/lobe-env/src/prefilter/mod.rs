//! Environments for glossy surfaces: a map convolved with a lobe for each roughness.
//!
//! Read first: [`prefilter`], which opens with the derivation. [`gather`] sums over a tree of averaged texels
//! ([`cell_tree`]) down to where [`cell_tolerance`] allows; [`importance`] draws samples after the lobe, and
//! [`brightness`] after the map. Uses map, mapping and reflection.

pub(crate) mod brightness;
pub(crate) mod cell_tolerance;
pub(crate) mod cell_tree;
pub(crate) mod gather;
pub(crate) mod importance;
pub(crate) mod prefilter;
