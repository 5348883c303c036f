//! Resampling between mappings: each texel of the target is an integral over its footprint in the source.
//!
//! Read [`resample`] first, which has the formula; then [`sample_points`] (where a texel is sampled), [`footprint`] and
//! [`source_window`] (the texels of the source under those samples), [`weights`], [`balance`] and [`lost`]
//! (conservation of energy); [`passes`] counts the passes over the target. [`cube_source`] makes cubes for filters.
//! Uses `map` and `mapping`.

pub(crate) mod balance;
pub(crate) mod cube_source;
pub(crate) mod footprint;
pub(crate) mod lost;
pub(crate) mod neighbor_clamp;
pub(crate) mod passes;
pub(crate) mod patch;
pub(crate) mod resample;
pub(crate) mod sample_points;
pub(crate) mod source_window;
pub(crate) mod sparse_sum;
pub(crate) mod undersampled;
pub(crate) mod weights;
