//! `lobe render`: a scene under distant light.
//!
//! `render` has the options, and renders and writes the pictures. Its inputs are in files of their own: the light
//! (`light`), the scene with its transfer (`transfer`) and the camera (`view`). Uses `args` and `run`.

pub(crate) mod light;
pub(crate) mod render;
pub(crate) mod transfer;
pub(crate) mod view;
