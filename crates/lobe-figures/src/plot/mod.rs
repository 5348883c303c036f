//! Plots: functions on the sphere, functions of one number, and lit balls.
//!
//! Functions on the sphere are drawn as a `balloon`, on an unfolded cube (`cube`, `cube_cross`), as a map (`lat_long`,
//! with `iso_lines`) or along a great circle (`polar_plot`); `pyramid` draws the basis in either form, and `ball`
//! lights a ball. `line_plot`, `profile_plot` and `polar_plot` write SVG through `drawing`; `mapping_figure` shows how
//! a mapping unfolds the sphere. `mesh` and `z_buffer` are the rasterizer beneath. Uses no other room.

pub(crate) mod ball;
pub(crate) mod balloon;
pub(crate) mod cube;
pub(crate) mod cube_cross;
pub(crate) mod drawing;
pub(crate) mod iso_lines;
pub(crate) mod lat_long;
pub(crate) mod line_plot;
pub(crate) mod mapping_figure;
pub(crate) mod mesh;
pub(crate) mod polar_plot;
pub(crate) mod profile_plot;
pub(crate) mod pyramid;
pub(crate) mod z_buffer;
