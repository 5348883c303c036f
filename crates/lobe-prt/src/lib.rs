//! Precomputed radiance transfer: what a scene does to distant light, baked once and applied to any light.
//!
//! Light from far away is an expansion L; what a point of a scene sends back of it is another, its transfer T, and the exit
//! radiance is their scalar product `B = Σᵢ Lᵢ Tᵢ`. Shadows and interreflections are in T: turning the light costs nothing.
//!
//! # Where to find what
//!
//! | purpose | item |
//! |---|---|
//! | what receivers do to light | [`Transfer`], [`Channels`] |
//! | the points it is baked for | [`Receivers`] |
//! | baking | [`fn@bake`], [`bake_resumable`], [`BakeOptions`], [`Mode`], [`Progress`], [`BakeReport`] |

mod bake;
mod bake_options;
mod basis_sum;
mod checkpoint;
mod chunks;
mod diffuse;
mod error;
mod fingerprint;
mod inset;
mod paths;
mod pilot;
mod receivers;
mod sobol;
mod transfer;
mod warp;

pub use bake::{bake, bake_resumable};
pub use bake_options::{BakeOptions, BakeReport, Mode, Progress};
pub use error::PrtError;
pub use receivers::Receivers;
pub use transfer::{Channels, Transfer};
