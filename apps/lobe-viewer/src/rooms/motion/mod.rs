//! The room of what moves: objects and skins whose shadows are products of fields, or exponentials of sums of spheres.
//!
//! Read `edits`, then `cast`, the parts and where hands put them, and `player`, which bakes the parts and lights moments beside the window,
//! then `stage`, a picture, `panes`, several of them and the truth, `spheres`, what is drawn over them, `clock`, the time, `hands`,
//! objects that are dragged, `controls`, the panel, `before`, the scene that is left, `motion_room`, which holds them together,
//! `changes` of its scene, and `picture`, its middle.

pub(crate) mod before;
pub(crate) mod cast;
pub(crate) mod changes;
pub(crate) mod clock;
pub(crate) mod controls;
pub(crate) mod edits;
pub(crate) mod hands;
pub(crate) mod motion_room;
pub(crate) mod panes;
pub(crate) mod picture;
pub(crate) mod player;
pub(crate) mod spheres;
pub(crate) mod stage;
