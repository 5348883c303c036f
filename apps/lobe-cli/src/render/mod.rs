//! TODO room render.

pub(crate) mod light;
pub(crate) mod render;
pub(crate) mod transfer;
pub(crate) mod view;
