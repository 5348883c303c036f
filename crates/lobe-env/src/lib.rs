//! Environment maps: pictures of everything around a point, read, written, projected and reconstructed.

mod azimuth;
mod env_map;
mod error;
pub mod lat_long;
mod polar;
mod project;
mod reconstruct;

pub use env_map::EnvMap;
pub use error::EnvError;
pub use project::project_env;
pub use reconstruct::reconstruct;
