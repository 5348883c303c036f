//! The room of what moves: objects and skins whose shadows are products of fields, or exponentials of sums of spheres.
//!
//! Read `edits`, then `player`, which bakes the parts and lights moments beside the window, then `stage`, the picture, `spheres`, what is drawn over
//! it, and `motion_room`.

pub(crate) mod edits;
pub(crate) mod motion_room;
pub(crate) mod player;
pub(crate) mod spheres;
pub(crate) mod stage;
