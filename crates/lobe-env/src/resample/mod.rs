//! Any mapping to any other: each texel of the new map is an integral over its footprint in the old one.
//!
//! Read first: [`resample`], which has the formula; then [`sample_points`] (where a texel is sampled), [`footprint`] and
//! [`source_window`] (what of the source that touches), [`weights`] and [`balance`] (that no energy is lost). Uses map
//! and mapping.

pub(crate) mod balance;
pub(crate) mod even_light;
pub(crate) mod fast_atan;
pub(crate) mod footprint;
pub(crate) mod patch;
pub(crate) mod resample;
pub(crate) mod sample_points;
pub(crate) mod source_window;
pub(crate) mod sparse_sum;
pub(crate) mod undersampled;
pub(crate) mod weights;
