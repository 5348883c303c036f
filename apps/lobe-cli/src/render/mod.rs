//! `lobe render`: a scene under distant light.
//!
//! `render` has the options and renders a picture. Its inputs are in files of their own: the light (`light`), the scene
//! with its transfer (`transfer`), what moves (`moving`), the path tracer (`truth`) and the camera (`view`). `stage` has what all pictures
//! show, `frames` renders one picture after the other and `pictures` writes them. Uses `args` and `run`.

pub(crate) mod frames;
pub(crate) mod light;
pub(crate) mod moving;
pub(crate) mod pictures;
pub(crate) mod render;
pub(crate) mod stage;
pub(crate) mod transfer;
pub(crate) mod truth;
pub(crate) mod view;
