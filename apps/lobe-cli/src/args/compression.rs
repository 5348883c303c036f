//! The options that compress transfer.

use clap::Args;
use lobe::prt::{CompressOptions, WeightBits};

use crate::args::values;

/// Options of transfer, which is compressed if any of them is given. Fields have the same with other words and defaults.
#[derive(Args)]
pub(crate) struct Compression {
    /// Compress to this many clusters at most, 1 to 65536; 1 gives ordinary principal components [default where there is
    /// compression: 64]
    #[arg(long, value_name = "K", value_parser = clusters)]
    pub(super) clusters: Option<usize>,
    /// Compress to this many components in each cluster, 0 to 192; 0 gives vector quantization [default likewise: 8]
    #[arg(long, value_name = "N", value_parser = components)]
    pub(super) components: Option<usize>,
    /// Compress, with this many bits for each weight: 8 or 16 in steps of its range, or 32 [default likewise: 16]
    #[arg(long, value_name = "BITS", value_parser = weight_bits)]
    pub(super) weights: Option<WeightBits>,
}

impl Compression {
    /// The name of an option that is given.
    pub(crate) fn asked(&self) -> Option<&'static str> {
        [
            (self.clusters.is_some(), "--clusters"),
            (self.components.is_some(), "--components"),
            (self.weights.is_some(), "--weights"),
        ]
        .into_iter()
        .find_map(|(is_asked, name)| is_asked.then_some(name))
    }

    /// The options of compression, whether or not one was given.
    pub(crate) fn options_or_default(&self) -> CompressOptions {
        self.options_over(CompressOptions::default().weights(WeightBits::U16))
    }

    /// The options of compression that are given, the others as here.
    pub(crate) fn options_over(&self, defaults: CompressOptions) -> CompressOptions {
        defaults
            .clusters(self.clusters.unwrap_or(defaults.clusters))
            .components(self.components.unwrap_or(defaults.components))
            .weights(self.weights.unwrap_or(defaults.weights))
    }
}

pub(super) fn clusters(text: &str) -> Result<usize, String> {
    values::whole(text, 1, CompressOptions::MAX_CLUSTERS, "a number of clusters")
}

pub(super) fn components(text: &str) -> Result<usize, String> {
    values::whole(text, 0, CompressOptions::MAX_COMPONENTS, "a number of components")
}

/// The bits of a weight.
pub(super) fn weight_bits(text: &str) -> Result<WeightBits, String> {
    match text {
        "8" => Ok(WeightBits::U8),
        "16" => Ok(WeightBits::U16),
        "32" => Ok(WeightBits::F32),
        _ => Err(format!("expected 8, 16 or 32 bits, found {text}")),
    }
}
