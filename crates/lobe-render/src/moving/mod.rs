//! Scenes that move: their parts, each with its place over time, and pictures of a moment.
//!
//! Read `moving_part`, `moving_lamp` and `moving_scene` first, then `moment`, the scene at one time, and `moments`, one
//! after the other; `read_moving` reads descriptions, `keep_transfer` takes over what a file holds (`kept_transfer`),
//! `split_parts` splits what stands still and `split_moving` what moves, `moving_bake` makes what parts lack,
//! `moving_shading` lights a moment by the options in `moving_options`, and `moving_picture` shows it; `moving_job` is all of that as a job asks for it. The others are
//! steps of these: `visibility_grid` in the `swept_box`, `part_files` and `sphere_albedo`, `part_backs`,
//! `part_obstacles`, `part_light` and `lamp_light`. Uses `camera`, `path_tracer` and `scene_view`.

pub(crate) mod keep_transfer;
mod kept_transfer;
mod lamp_light;
pub(crate) mod moment;
pub(crate) mod moments;
pub(crate) mod moving_bake;
pub(crate) mod moving_job;
pub(crate) mod moving_lamp;
pub(crate) mod moving_options;
pub(crate) mod moving_part;
pub(crate) mod moving_picture;
pub(crate) mod moving_scene;
pub(crate) mod moving_shading;
mod part_backs;
mod part_files;
mod part_light;
pub(crate) mod part_obstacles;
mod read_moving;
mod sphere_albedo;
mod split_moving;
pub(crate) mod split_parts;
mod swept_box;
pub(crate) mod visibility_grid;
