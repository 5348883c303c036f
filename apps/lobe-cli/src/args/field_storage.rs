//! Storage of fields, lamps and visibility: the type of number, clusters and components.

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::prt::{CompressOptions, WeightBits};
use lobe::shadow::{FieldStorage, StorageReport};

use crate::args::compression::{Compression, clusters, components, weight_bits};
use crate::run::talk::Talk;

/// Clusters and components of `--storage clustered` where none are given: at order 4 less than a third of the bytes of single
/// precision.
const CLUSTERS: usize = 64;
const COMPONENTS: usize = 4;

/// The options of storage.
#[derive(Args)]
pub(crate) struct StorageOptions {
    /// How numbers are stored
    #[arg(long, value_enum, default_value = "f32")]
    storage: Storage,
    /// With --storage clustered: as many clusters at most, 1 to 65536; 1 gives ordinary principal components [default: 64]
    #[arg(long, value_name = "K", value_parser = clusters)]
    clusters: Option<usize>,
    /// With --storage clustered: as many components in each cluster, 0 to 192; 0 gives vector quantization [default: 4]
    #[arg(long, value_name = "N", value_parser = components)]
    components: Option<usize>,
    /// With --storage clustered: as many bits for each weight: 8 or 16 in steps of its range, or 32 [default: 32]
    #[arg(long, value_name = "BITS", value_parser = weight_bits)]
    weights: Option<WeightBits>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Storage {
    /// Four bytes each
    F32,
    /// Two bytes each
    F16,
    /// One byte each, in even steps over the range of each coefficient
    U8,
    /// Clustered principal components, of 64 clusters and 4 components unless --clusters and --components say otherwise
    Clustered,
}

impl StorageOptions {
    /// The option that asks for other storage than that of single precision, if one does.
    pub(crate) fn asked(&self) -> Option<&'static str> {
        (self.storage != Storage::F32).then_some("--storage").or_else(|| self.compression().asked())
    }

    fn compression(&self) -> Compression {
        Compression { clusters: self.clusters, components: self.components, weights: self.weights }
    }

    /// The form that is asked for; refuses options of compression where nothing is compressed.
    pub(crate) fn form(&self) -> anyhow::Result<FieldStorage> {
        if self.storage != Storage::Clustered
            && let Some(option) = self.compression().asked()
        {
            bail!("{option}: only of --storage clustered; leave the option out");
        }
        Ok(match self.storage {
            Storage::F32 => FieldStorage::F32,
            Storage::F16 => FieldStorage::F16,
            Storage::U8 => FieldStorage::U8,
            Storage::Clustered => {
                let defaults = CompressOptions::default().clusters(CLUSTERS).components(COMPONENTS);
                FieldStorage::Clustered(self.compression().options_over(defaults))
            }
        })
    }

    /// Notes that a form takes more bytes than single precision.
    pub(crate) fn tell_if_larger(&self, report: &StorageReport, talk: Talk) {
        if report.bytes > report.bytes_before {
            let (found, single) = (report.bytes, report.bytes_before);
            let text = format!("takes {found} bytes, more than the {single} of f32: there are too few points for it");
            let name = self.storage.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned());
            talk.note(&format!("--storage {name}"), &text);
        }
    }
}
