//! Spherical-harmonic lighting: the one crate to depend on.

pub use lobe_env as env;
pub use lobe_render as render;
pub use lobe_sh as sh;
