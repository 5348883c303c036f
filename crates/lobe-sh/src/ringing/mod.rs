//! TODO room ringing.

pub(crate) mod content_window;
pub(crate) mod cutting_planes;
pub(crate) mod dering;
pub(crate) mod quadratic_dering;
pub(crate) mod quadric_windows;
pub(crate) mod sloan_table;
