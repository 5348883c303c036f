//! The room of functions on the sphere: balloons, their coefficients, and four studies.
//!
//! Read `edits`, the functions that can be chosen, `figures`, how each is shown, then the studies `rotate`, `multiply`, `ringing` and
//! `ambient_cube`, and `functions_room`, which shows one of them.

pub(crate) mod ambient_cube;
pub(crate) mod edits;
pub(crate) mod figures;
pub(crate) mod functions_room;
pub(crate) mod multiply;
pub(crate) mod ringing;
pub(crate) mod rotate;
