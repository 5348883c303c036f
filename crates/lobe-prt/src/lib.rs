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
//! | the points it is baked for | [`Receivers`]; [`TexelReceivers`] of a lightmap |
//! | baking | [`fn@bake`], [`bake_resumable`], [`BakeOptions`], [`Mode`], [`Progress`], [`BakeReport`] |
//! | glossy receivers | [`bake_matrices`], [`TransferMatrices`] |
//! | what moves through a scene | [`bake_neighbourhood`], [`Neighbourhood`], [`Grid`] |

mod bake;
mod bake_options;
mod basis_sum;
mod checkpoint;
mod chunks;
mod diffuse;
mod error;
mod fingerprint;
mod inset;
mod neighbourhood;
mod outer_sum;
mod paths;
mod pilot;
mod receivers;
mod sobol;
mod texel_receivers;
mod transfer;
mod transfer_matrix;
mod warp;

pub use bake::{bake, bake_resumable};
pub use bake_options::{BakeOptions, BakeReport, Mode, Progress};
pub use error::PrtError;
pub use neighbourhood::{Grid, Neighbourhood, bake_neighbourhood};
pub use receivers::Receivers;
pub use texel_receivers::TexelReceivers;
pub use transfer::{Channels, Transfer};
pub use transfer_matrix::{TransferMatrices, bake_matrices};
