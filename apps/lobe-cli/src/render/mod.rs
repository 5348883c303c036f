//! `lobe render`: a scene under distant light.
//!
//! `methods` has the sub-commands with their options, `render` makes the picture of one, by a method of `mode`. Inputs
//! are in files of their own: the light (`light`), when something moves (`time`), how surfaces reflect (`surfaces`), the path tracer (`truth`), environment mapping (`environment`) and
//! the camera (`view`). `stage` has what all pictures show, `frames` renders one picture after the other and `pictures`
//! writes them. Uses `args` and `run`.

pub(crate) mod environment;
pub(crate) mod frames;
pub(crate) mod light;
pub(crate) mod methods;
pub(crate) mod mode;
pub(crate) mod pictures;
pub(crate) mod render;
pub(crate) mod stage;
pub(crate) mod surfaces;
pub(crate) mod time;
pub(crate) mod truth;
pub(crate) mod view;
