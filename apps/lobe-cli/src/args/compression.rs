//! The options that compress transfer.

use clap::Args;
use lobe::prt::{CompressOptions, Transfer, WeightBits};

use crate::args::values;

/// As many as a row of the highest order in color has numbers.
const MAX_COMPONENTS: usize = 3 * Transfer::MAX_ORDER * Transfer::MAX_ORDER;

/// Options of what can be compressed, and is if any of them is given.
#[derive(Args)]
pub(crate) struct Compression {
    /// Compress to this many clusters of vertices at most, 1 to 65536 [default with --components or --weights: 64]
    #[arg(long, value_name = "K", value_parser = clusters)]
    clusters: Option<usize>,
    /// Compress to this many components in each cluster [default with --clusters or --weights: 8]
    #[arg(long, value_name = "N", value_parser = components)]
    components: Option<usize>,
    /// Compress, with this many bits for each weight: 8, 16 or 32 [default with --clusters or --components: 32]
    #[arg(long, value_name = "BITS", value_parser = weight_bits)]
    weights: Option<WeightBits>,
}

impl Compression {
    /// The options of compression, if that was asked for.
    pub(crate) fn options(&self) -> Option<CompressOptions> {
        if self.clusters.is_none() && self.components.is_none() && self.weights.is_none() {
            return None;
        }
        let mut options = CompressOptions::default();
        options.clusters = self.clusters.unwrap_or(options.clusters);
        options.components = self.components.unwrap_or(options.components);
        options.weights = self.weights.unwrap_or(WeightBits::F32);
        Some(options)
    }
}

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
