//! TODO room prefilter.

pub(crate) mod brightness;
pub(crate) mod cell_tolerance;
pub(crate) mod cell_tree;
pub(crate) mod gather;
pub(crate) mod importance;
pub(crate) mod prefilter;
