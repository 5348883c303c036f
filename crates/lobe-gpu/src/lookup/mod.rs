//! Functions of a direction for shaders: the basis, environment maps, and their reflection.
//!
//! Read `basis`, `environment` and `specular`, each the counterpart of a module on the processor. Uses `renderer`.

pub(crate) mod basis;
pub(crate) mod environment;
pub(crate) mod specular;
