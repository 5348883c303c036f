//! Pictures of scenes on the device: surfaces whose light is known, what is behind them, and display.
//!
//! Read `camera`, then `scene_buffers`, which lays a scene out for shaders, then `surface_shading`, the ways to light it, and
//! `scene_view`, which puts the passes in order. Uses `transfer`, `lookup`, `renderer` and `context`.

pub(crate) mod camera;
pub(crate) mod scene_buffers;
pub(crate) mod scene_view;
pub(crate) mod surface_shading;
