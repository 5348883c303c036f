//! Cameras: the axes of a picture, and the rays from the eye through its points.
//!
//! Read `view` first, then `camera`. Uses no other room.

pub(crate) mod camera;
pub(crate) mod view;
