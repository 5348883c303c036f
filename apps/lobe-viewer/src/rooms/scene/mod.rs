//! The room that the window opens with: a baked scene under a turning sky.
//!
//! Read `edits`, what a user can change and undo, then `scene_light`, the light that follows from it, `baked`, what
//! is known of the transfer, `viewport`, the picture, `still`, what its truth depends on, `probe`, the transfer of a
//! vertex, `controls` and `lamps`, the panel, `opened` and `work`, what is open and what is under way, and
//! `scene_room`, which holds them together.

pub(crate) mod baked;
pub(crate) mod controls;
pub(crate) mod edits;
pub(crate) mod lamps;
pub(crate) mod opened;
pub(crate) mod probe;
pub(crate) mod scene_light;
pub(crate) mod scene_room;
pub(crate) mod still;
pub(crate) mod viewport;
pub(crate) mod work;
