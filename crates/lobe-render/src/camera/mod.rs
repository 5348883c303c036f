//! The eye: the axes of its picture, and the rays that leave it.
//!
//! Read [`view`] first, then [`mod@camera`]. This room uses the ground floor only.

pub(crate) mod camera;
pub(crate) mod view;
