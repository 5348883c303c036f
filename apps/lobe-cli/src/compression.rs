//! How transfer is compressed, on the command line.

use lobe::prt::{CompressOptions, Transfer, WeightBits};

use crate::values;

/// As many as a row of the highest order in colour has numbers.
const MAX_COMPONENTS: usize = 3 * Transfer::MAX_ORDER * Transfer::MAX_ORDER;

pub(crate) fn clusters(text: &str) -> Result<usize, String> {
    values::whole(text, 1, CompressOptions::MAX_CLUSTERS, "a number of clusters")
}

pub(crate) fn components(text: &str) -> Result<usize, String> {
    values::whole(text, 0, MAX_COMPONENTS, "a number of components")
}

/// The bits of a weight.
pub(crate) fn weight_bits(text: &str) -> Result<WeightBits, String> {
    match text {
        "8" => Ok(WeightBits::U8),
        "16" => Ok(WeightBits::U16),
        "32" => Ok(WeightBits::F32),
        _ => Err(format!("expected 8, 16 or 32 bits, found {text}")),
    }
}
