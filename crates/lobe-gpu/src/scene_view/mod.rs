//! Pictures of scenes on the device: surfaces whose light is known, what is behind them, and display.
//!
//! Read `camera` and `options`, then `surface_pieces`, which cuts what is too large for a device, `scene_buffers`,
//! which lays a scene out for shaders, `surface_pass`, `suns_apart`, `sun_maps` and `sunlit_vertices`, for suns that
//! cast shadows by themselves, `finishes` and `gltf_shading`, for surfaces that shine, `lights` and `surface_shading`,
//! the ways to light a scene, `frame_passes`, what is drawn in each frame, and `scene_view`, which puts all in order.
//! Uses `moving`, `transfer`, `lookup`, `renderer` and
//! `context`.

pub(crate) mod camera;
pub(crate) mod expected;
pub(crate) mod finishes;
pub(crate) mod frame_passes;
pub(crate) mod gltf_shading;
pub(crate) mod lights;
pub(crate) mod options;
pub(crate) mod scene_buffers;
pub(crate) mod scene_view;
pub(crate) mod sun_maps;
pub(crate) mod sunlit_vertices;
pub(crate) mod suns_apart;
pub(crate) mod surface_pass;
pub(crate) mod surface_pieces;
pub(crate) mod surface_shading;
