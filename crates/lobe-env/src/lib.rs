//! Environment maps: pictures of everything around a point, read, written, projected and reconstructed.

mod env_map;
mod error;
pub mod lat_long;

pub use env_map::EnvMap;
pub use error::EnvError;
