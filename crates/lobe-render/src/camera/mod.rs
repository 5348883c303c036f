//! The eye: the axes of its picture, and the rays that leave it.
//!
//! Read `view` first, then `camera`. Uses no other room.

pub(crate) mod camera;
pub(crate) mod view;
