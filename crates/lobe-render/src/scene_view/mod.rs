//! TODO room scene_view.

pub(crate) mod camera;
pub(crate) mod receiver_picture;
