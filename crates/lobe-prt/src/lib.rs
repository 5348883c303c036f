//! Precomputed radiance transfer: what a scene does to distant light, baked once and applied to any light.
//!
//! Light from far away is an expansion L; what a point of a scene sends back of it is another, its transfer T, and the exit
//! radiance is their scalar product `B = Σᵢ Lᵢ Tᵢ`. Shadows and interreflections are in T: turning the light costs nothing.
//!
//! # Where to find what
//!
//! | purpose | item |
//! |---|---|
//! | what receivers do to light | [`Transfer`], [`Channels`]; without holding it in memory [`TransferRows`], [`StoredTransfer`] |
//! | the points it is baked for | [`Receivers`]; [`TexelReceivers`] of a lightmap, shown by [`Lightmap`] |
//! | vertices where transfer needs them | [`split_adaptively`], [`split_adaptively_resumable`], [`AdaptiveOptions`], [`AdaptiveReport`] |
//! | baking | [`fn@bake`], [`bake_resumable`], [`BakeOptions`], [`Mode`], [`Progress`], [`BakeReport`] |
//! | scenes whose vertices carry transfer | [`BakedGlb`], [`fn@read_baked`], [`Baked`] |
//! | transfer alone | [`write_transfer`], [`read_transfer`]; of a lightmap as a picture [`write_lightmap`], [`read_lightmap`] |
//! | the same in fewer bytes | [`CompressedTransfer`], [`error_curve`]; any table: [`compress_table`], [`compress_table_within`] |
//! | lobes that turn with a surface that bends | [`fit_zonal`], [`ZonalTransfer`] |
//! | files of these two, and of any form | [`write_compressed_transfer`], [`write_zonal_transfer`] and their readers; [`AnyTransfer`], [`read_any_transfer`] |
//! | glossy receivers | [`bake_matrices`], [`bake_matrices_resumable`], [`TransferMatrices`], [`MatrixRows`], [`StoredMatrices`] |
//! | what moves through a scene | [`bake_neighbourhood`], [`bake_neighbourhood_resumable`], [`Neighbourhood`], [`Grid`] |
//! | files of these two | [`write_matrices`], [`write_neighbourhood`] and their readers |
//! | telling one piece of long work from another | [`Fingerprint`] |

mod adaptive;
mod any_transfer;
mod bake;
mod bake_options;
mod baked_compressed;
mod baked_glb;
mod baked_layout;
mod basis_sum;
mod bfgs;
mod checkpoint;
mod chunks;
mod compress;
mod compressed_file;
mod compressed_table;
mod compressed_transfer;
mod cpca;
mod diffuse;
mod eigen;
mod error;
mod fingerprint;
mod inset;
mod lanes;
mod lightmap;
mod lightmap_file;
mod lobes;
mod matrix_file;
mod matrix_rows;
mod meter;
mod nearest;
mod neighbourhood;
mod outer_sum;
mod paths;
mod pca;
mod pilot;
mod read_baked;
mod receivers;
mod shade;
mod sobol;
mod stored_rows;
mod tensor_file;
mod texel_receivers;
mod texel_rows;
mod transfer;
mod transfer_file;
mod transfer_matrix;
mod transfer_rows;
mod warp;
mod zonal_fit;
mod zonal_transfer;

pub use adaptive::{AdaptiveOptions, AdaptiveReport, split_adaptively, split_adaptively_resumable};
pub use any_transfer::{AnyTransfer, read_any_transfer};
pub use bake::{bake, bake_resumable};
pub use bake_options::{BakeOptions, BakeReport, Mode, Progress};
pub use baked_glb::BakedGlb;
pub use compress::{
    CompressOptions, CompressReport, CurvePoint, compress_table, compress_table_within, error_curve,
    error_curve_watched,
};
pub use compressed_file::{
    read_compressed_transfer, read_zonal_transfer, write_compressed_transfer, write_zonal_transfer,
};
pub use compressed_table::{CompressedTable, WeightBits, Weights};
pub use compressed_transfer::CompressedTransfer;
pub use error::PrtError;
pub use fingerprint::Fingerprint;
pub use lightmap::Lightmap;
pub use lightmap_file::{read_lightmap, write_lightmap};
pub use matrix_file::{read_matrices, read_neighbourhood, write_matrices, write_neighbourhood};
pub use matrix_rows::{MatrixRows, StoredMatrices};
pub use neighbourhood::{Grid, Neighbourhood, bake_neighbourhood, bake_neighbourhood_resumable};
pub use read_baked::{Baked, read_baked, read_baked_within};
pub use receivers::Receivers;
pub use texel_receivers::TexelReceivers;
pub use texel_rows::TexelRows;
pub use transfer::{Channels, Transfer};
pub use transfer_file::{read_transfer, write_transfer};
pub use transfer_matrix::{TransferMatrices, bake_matrices, bake_matrices_resumable};
pub use transfer_rows::{StoredTransfer, TransferRows};
pub use zonal_fit::{ZonalFitOptions, ZonalFitReport, fit_zonal, fit_zonal_watched};
pub use zonal_transfer::ZonalTransfer;
