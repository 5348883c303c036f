//! Precomputed radiance transfer: what a scene does to distant light, baked once and applied to any light.
//!
//! Light from far away is an expansion L; what a point of a scene sends back of it is another, its transfer T, and the
//! exit radiance is their scalar product `B = Σᵢ Lᵢ Tᵢ`. Shadows and interreflections are in T: turning the light costs
//! nothing.
//!
//! # Index
//!
//! | purpose | item |
//! |---|---|
//! | transfer vectors | [`Transfer`], [`Channels`]; in 16 bits [`HalfTransfer`], [`HalfReport`]; without holding it in memory [`TransferRows`], [`StoredTransfer`] |
//! | receivers | [`Receivers`]; [`TexelReceivers`] of a lightmap, shown by [`Lightmap`], finished by [`FinishOptions`] |
//! | transfer and matrices at vertices by least squares | [`bake_vertices`], [`FittedVertices`] |
//! | adaptive subdivision | [`split_adaptively`], [`AdaptiveOptions`], [`AdaptiveReport`] |
//! | baking | [`fn@bake`], [`bake_on_disk`], [`bake_shard`], [`BakeOptions`], [`BakeMode`], [`AlbedoMode`], [`BakeReport`] |
//! | a bake as a piece of work, with its points, shards and file | [`BakeWork`], [`BakedRows`], [`Fitted`] |
//! | all that is asked of a bake as one value, and all that is done for it | [`BakeJob`], [`UnwrapMode`]; step by step [`OpenBake`], [`PreparedBake`], [`BakeDone`] |
//! | baked glTF scenes | [`BakedGlb`], [`fn@read_baked`], [`Baked`]; their backs [`BakedBacks`], [`double_sided_vertices`]; baked or not: [`read_baked_or_scene`]; of an open file: [`BakedTransfer`] |
//! | files of transfer alone | [`write_transfer`], [`write_half_transfer`], [`read_transfer`]; lightmaps [`write_lightmap`], [`read_lightmap`] |
//! | compression (CPCA) | [`CompressedTransfer`], [`error_curve`] |
//! | compression of any table | [`compress_table`], [`compress_table_within`] |
//! | zonal lobes of deformable surfaces | [`fit_zonal`], [`ZonalTransfer`] |
//! | files of both | [`write_compressed_transfer`], [`read_compressed_transfer`], [`write_zonal_transfer`], [`read_zonal_transfer`] |
//! | files of any form | [`AnyTransfer`], [`read_any_transfer`] |
//! | transfer matrices | [`TransferMatrices`], [`MatrixRows`], [`StoredMatrices`] |
//! | baking matrices | [`bake_matrices`]; on disk and in shards [`BakeWork`] |
//! | neighborhood transfer | [`bake_neighborhood`], [`Neighborhood`], [`NeighborhoodGrid`] |
//! | files of matrices | [`write_matrices`], [`read_matrices`], [`write_neighborhood`], [`read_neighborhood`] |
//! | the record of how transfer was made | [`Recipe`] |
//! | fingerprints of scenes | [`fingerprint_scene`], [`fingerprint_finish`], [`scene_hash`]; of arithmetic [`fingerprint_arithmetic`] |
//!
//! Long functions end with a [`lobe_io::Job`], which says who watches them and in which file they are kept. Those that
//! bake can be resumed; searches ([`fit_zonal`], [`compress_table`] and what is built on them) cannot, and refuse a
//! file.

mod bake;
mod bake_job;
mod bake_work;
mod compression;
mod error;
mod files;
mod finishing;
mod fit;
mod job;
mod receivers;
mod recipe;
mod sampling;
mod transfer;
mod zonal;

pub use bake::bake::{bake, bake_on_disk, bake_shard};
pub use bake::glossy::bake_matrices;
pub use bake::options::{AlbedoMode, BakeMode, BakeOptions, BakeReport};
pub use bake::transfer_grid::{Neighborhood, NeighborhoodGrid, bake_neighborhood};
pub use bake_job::bake_job::{BakeJob, UnwrapMode};
pub use bake_job::open_bake::OpenBake;
pub use bake_job::prepared_bake::{BakeDone, PreparedBake};
pub use bake_work::{BakeWork, BakedRows, Fitted};
pub use compression::compress::{
    CompressOptions, CompressReport, CurvePoint, compress_table, compress_table_within, error_curve,
};
pub use compression::compressed_table::{CompressedTable, TableWeights, WeightBits};
pub use compression::compressed_transfer::CompressedTransfer;
pub use compression::compression_options::CompressionOptions;
pub use error::PrtError;
pub use files::any_transfer::{AnyTransfer, read_any_transfer, read_any_transfer_bytes};
pub use files::baked_backs::{BakedBacks, double_sided_vertices};
pub use files::baked_extras::LOBE_EXTRAS_VERSION;
pub use files::baked_glb::{BakedGlb, MoreTransfer};
pub use files::compressed_file::{
    read_compressed_transfer, read_compressed_transfer_bytes, read_zonal_transfer, read_zonal_transfer_bytes,
    write_compressed_transfer, write_zonal_transfer,
};
pub use files::lightmap_file::{read_lightmap, read_lightmap_bytes, write_lightmap};
pub use files::lightmap_glb::LightmapGlb;
pub use files::matrix_file::{
    read_matrices, read_matrices_bytes, read_neighborhood, read_neighborhood_bytes, write_matrices, write_neighborhood,
};
pub use files::memory::{BYTES_FOR_EACH, check_file_of_numbers};
pub use files::open_scene::OpenScene;
pub use files::read_baked::{
    Baked, BakedOrScene, BakedTransfer, baked_pose, is_baked, read_baked, read_baked_bytes, read_baked_or_scene,
    read_baked_or_scene_bytes,
};
pub use files::transfer_file::{read_transfer, read_transfer_bytes, write_half_transfer, write_transfer};
pub use finishing::finish::{FinishOptions, FinishReport};
pub use fit::adaptive::{AdaptiveOptions, AdaptiveReport, split_adaptively};
pub use fit::fitted_vertices::FittedVertices;
pub use fit::vertex_fit::bake_vertices;
pub use job::fingerprint::{fingerprint_arithmetic, fingerprint_finish, fingerprint_scene, scene_hash};
pub use receivers::lightmap::Lightmap;
pub use receivers::receivers::Receivers;
pub use receivers::texel_receivers::TexelReceivers;
pub use receivers::texel_rows::TexelRows;
pub use recipe::Recipe;
pub use transfer::glossy_lobe::GlossyLobe;
pub use transfer::half_transfer::{HalfReport, HalfTransfer};
pub use transfer::transfer::{Channels, Transfer};
pub use transfer::transfer_matrices::TransferMatrices;
pub use transfer::transfer_parts::TransferParts;
pub use transfer::transfer_rows::{MatrixRows, StoredMatrices, StoredTransfer, TransferRows};
pub use zonal::zonal_fit::{ZonalFitOptions, ZonalFitReport, fit_zonal};
pub use zonal::zonal_transfer::ZonalTransfer;
