//! TODO room light_extraction.

pub(crate) mod extract;
pub(crate) mod light_fit;
pub(crate) mod peaks;
pub(crate) mod refine;
