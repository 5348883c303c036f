//! Environment maps: pictures of everything around a point, read, written, projected and reconstructed.
//!
//! ```
//! use lobe_env::{bundled, irradiance_at, irradiance_sh};
//! use lobe_sh::{Dir, Expansion};
//!
//! let sky = bundled::sunset().map();
//! let irradiance = irradiance_sh(&sky, 3);
//! // Nine numbers for each colour tell how much light falls on a surface that faces up ..
//! let fast = irradiance.eval(Dir::Z);
//! // .. within a few percent of the sum over all texels.
//! let exact = irradiance_at(&sky, &[Dir::Z])[0];
//! assert!((fast.g / exact.g - 1.0).abs() < 0.05);
//! ```
//!
//! [`read_env`] and [`write_env`] are the files, [`EnvMap`] the picture, [`lat_long`] its mapping, [`project_env`] and
//! [`reconstruct`] the way to expansions and back, [`irradiance_sh`] and [`irradiance_at`] what a matte surface sees.
//!
//! A map is constant over each texel wherever it is integrated, and interpolated where it is looked at
//! ([`EnvMap::radiance`]). The first makes sums over texels exact: solid angles, means, projections and the light of a
//! sun of one texel have no error of sampling.

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
