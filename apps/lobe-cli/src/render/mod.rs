//! `lobe render`: a scene under distant light.
//!
//! `render` has the options and renders a picture, by one of the methods in `mode`. Its inputs are in files of their own: the
//! light (`light`), the scene with its transfer (`transfer`), what moves (`moving`), how surfaces reflect (`surfaces`), the path
//! tracer (`truth`), environment mapping (`environment`) and the camera (`view`). `stage` has what all pictures show, `frames`
//! renders one picture after the other and `pictures` writes them. Uses `args` and `run`.

pub(crate) mod environment;
pub(crate) mod frames;
pub(crate) mod light;
pub(crate) mod mode;
pub(crate) mod moving;
pub(crate) mod pictures;
pub(crate) mod render;
pub(crate) mod stage;
pub(crate) mod surfaces;
pub(crate) mod transfer;
pub(crate) mod truth;
pub(crate) mod view;
