//! Options of compression, of all jobs that may compress what they write.

use lobe_io::{JobOptions, OptionField, OptionKind, options};

use crate::compression::compress::CompressOptions;
use crate::compression::compressed_table::WeightBits;

options! {
    /// How rows of numbers are compressed, see [`CompressOptions`]. What is left open depends on what the rows are; the
    /// words are those of transfer.
    pub struct CompressionOptions {
        /// Compress to this many clusters at most; 1 gives ordinary principal components
        clusters: Option<usize> = None,
            OptionKind::Whole { least: 1, most: CompressOptions::MAX_CLUSTERS as u64, what: "a number of clusters" },
            "K", "64";
        /// Compress to this many components in each cluster; 0 gives vector quantization
        components: Option<usize> = None,
            OptionKind::Whole { least: 0, most: CompressOptions::MAX_COMPONENTS as u64, what: "a number of components" },
            "N", "8";
        /// Compress, with this many bits for each weight: 8 or 16 in steps of its range, or 32, which programs that keep floats alone do not spoil (Blender)
        weights: Option<usize> = None, OptionKind::OneOf(&[8, 16, 32]), "BITS", "16";
    }
}

impl JobOptions for CompressionOptions {
    fn fields() -> Vec<&'static OptionField> {
        Self::FIELDS.iter().collect()
    }

    fn heading_of(_name: &str) -> Option<&'static str> {
        Some("Compression")
    }
}

impl CompressionOptions {
    /// The names of all.
    pub const NAMES: [&'static str; 3] = ["clusters", "components", "weights"];

    /// Whether any is given.
    #[must_use]
    pub fn is_asked(&self) -> bool {
        *self != Self::default()
    }

    /// What is given, over other options.
    #[must_use]
    pub fn over(&self, options: CompressOptions) -> CompressOptions {
        let weights = match self.weights {
            Some(8) => WeightBits::U8,
            Some(16) => WeightBits::U16,
            Some(32) => WeightBits::F32,
            _ => options.weights,
        };
        let (clusters, components) = (options.clusters, options.components);
        options
            .clusters(self.clusters.unwrap_or(clusters))
            .components(self.components.unwrap_or(components))
            .weights(weights)
    }

    /// Options of compressed transfer: 64 clusters of 8 components, with weights of 16 bits, unless they say otherwise.
    #[must_use]
    pub fn of_transfer(&self) -> CompressOptions {
        self.over(CompressOptions::default().weights(WeightBits::U16))
    }
}
