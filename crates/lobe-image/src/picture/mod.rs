//! Pictures in linear light, and their conversion for display.
//!
//! Read [`picture`] first, then [`tone`], which maps light to displayable bytes, and [`png`], which writes those as
//! files ([`animated_png`] several). [`resize`] and [`sheet`] derive pictures from pictures; [`text`], [`colormap`] and
//! [`color_bar`] draw into them; [`primaries`] changes the primaries of their colors. Uses no other room.

pub(crate) mod animated_png;
pub(crate) mod color_bar;
pub(crate) mod colormap;
pub(crate) mod picture;
pub(crate) mod png;
pub(crate) mod primaries;
pub(crate) mod resize;
pub(crate) mod sheet;
pub(crate) mod srgb;
pub(crate) mod text;
pub(crate) mod tone;
pub(crate) mod tone_curve;
