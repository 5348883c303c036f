//! Widgets of the rooms: a camera that orbits, pictures, balloons, coefficients, curves, a list of files, and pictures that
//! a graphics device draws.
//!
//! Read `orbit`, then `named`, which gives names to what is painted, `tone`, `drawing_time`, `picture` and `balloon`, `bars`, `coefficient_table`, `curve` and `file_list`,
//! `history`, `notice`, `status`, `within`, and `gpu`. Uses no other room.

pub(crate) mod balloon;
pub(crate) mod bars;
pub(crate) mod coefficient_table;
pub(crate) mod curve;
pub(crate) mod drawing_time;
pub(crate) mod file_list;
pub(crate) mod gpu;
pub(crate) mod history;
pub(crate) mod named;
pub(crate) mod notice;
pub(crate) mod orbit;
pub(crate) mod picture;
pub(crate) mod status;
pub(crate) mod tone;
pub(crate) mod within;
