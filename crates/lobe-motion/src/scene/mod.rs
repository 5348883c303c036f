//! A scene that moves: parts and lamps, each with its place over time.
//!
//! Read `moving_part`, `moving_lamp` and `moving_scene` first, then `moment`, the scene at one time, and `moments`, one
//! after the other. Uses `baked`.

pub(crate) mod moment;
pub(crate) mod moments;
pub(crate) mod moving_lamp;
pub(crate) mod moving_part;
pub(crate) mod moving_scene;
