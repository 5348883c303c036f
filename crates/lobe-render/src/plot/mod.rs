//! TODO room plot.

pub(crate) mod axes;
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
