//! Functions of a direction for shaders: the basis, irradiance, environment maps, and their reflection.
//!
//! Read `towards`, which asks a WGSL function for many directions at once, then `basis`, `irradiance`, `environment` and
//! `specular`, each the counterpart of a module on the processor. Uses `renderer` and `context`.

pub(crate) mod basis;
pub(crate) mod environment;
pub(crate) mod irradiance;
pub(crate) mod specular;
pub(crate) mod towards;
