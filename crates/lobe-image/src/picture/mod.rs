//! Pictures in linear light, and the way to the eye.
//!
//! Read first: [`picture`], then [`tone`], which makes displayable bytes of light, and [`png`], which makes files of those
//! ([`animated_png`] of several). [`resize`] and [`sheet`] make pictures of pictures; [`text`], [`colormap`] and
//! [`color_bar`] draw into them. Uses no other room.

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
