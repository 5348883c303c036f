//! TODO

pub(crate) mod content_window;
pub(crate) mod cutting_planes;
pub(crate) mod dering;
pub(crate) mod outcome;
pub(crate) mod quadratic_dering;
pub(crate) mod quadratic_windows;
pub(crate) mod sloan_table;
