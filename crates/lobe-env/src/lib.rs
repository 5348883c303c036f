//! Environment maps: pictures of everything around a point, read, written, projected and reconstructed.

mod azimuth;
pub mod bundled;
mod env_map;
mod error;
mod irradiance;
pub mod lat_long;
mod polar;
mod project;
mod read;
mod read_exr;
mod read_hdr;
mod reconstruct;
mod write;

pub use env_map::EnvMap;
pub use error::EnvError;
pub use irradiance::{irradiance_at, irradiance_map, irradiance_map_brute_force, irradiance_sh};
pub use project::project_env;
pub use read::{FileFormat, Nonfinite, ReadOptions, ReadReport, read_env, read_env_bytes};
pub use reconstruct::reconstruct;
pub use write::{WriteOptions, WriteReport, write_env};
