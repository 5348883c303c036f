//! Removing ringing: windows that make a function non-negative.
//!
//! Read [`dering`] first. The least change comes from [`cutting_planes`] (Kelley's method) at any order and from
//! [`quadratic_dering`] with [`quadratic_windows`] at order 3; [`sloan_table`] is the published way. [`content_window`]
//! keeps the light as it is. [`outcome`] says how an attempt ended. Uses `basis`, `expansion`, `extrema`, `filter`,
//! `rotation`, `solver` and `sphere`.

pub(crate) mod content_window;
pub(crate) mod cutting_planes;
pub(crate) mod dering;
pub(crate) mod outcome;
pub(crate) mod quadratic_dering;
pub(crate) mod quadratic_windows;
pub(crate) mod sloan_table;
