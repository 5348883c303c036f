//! Scenes that move: their parts, each with its place over time, and pictures of a moment.
//!
//! Read `moving_part` and `moving_scene` first, then `moment`, the scene at one time, and `moments`, one after the other;
//! `moving_bake` makes what parts lack, `moving_shading` lights a moment, and `moving_picture` shows it. Uses `camera` and
//! `scene_view`.

pub(crate) mod moment;
pub(crate) mod moments;
pub(crate) mod moving_bake;
pub(crate) mod moving_part;
pub(crate) mod moving_picture;
pub(crate) mod moving_scene;
pub(crate) mod moving_shading;
