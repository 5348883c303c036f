//! TODO room resample.

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
