//! Cameras: the axes of a picture, and the rays from the eye through its points.
//!
//! Read `view` first, then `camera` and `view_point`, which makes one for a scene, as `camera_options` ask. Uses no other
//! room.

pub(crate) mod camera;
pub(crate) mod camera_options;
pub(crate) mod tone_options;
pub(crate) mod view;
pub(crate) mod view_point;
