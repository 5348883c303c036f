//! TODO room picture.

pub(crate) mod animated_png;
pub(crate) mod color_bar;
pub(crate) mod colormap;
pub(crate) mod picture;
pub(crate) mod png;
pub(crate) mod resize;
pub(crate) mod sheet;
pub(crate) mod srgb;
pub(crate) mod text;
pub(crate) mod tone;
