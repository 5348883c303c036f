//! Storage of fields, lamps and visibility: the type of number, clusters and components.

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::prt::WeightBits;
use lobe::shadow::{FieldStorage, StorageReport};

use crate::args::compression::{Compression, clusters, components, weight_bits};
use crate::run::talk::Talk;

/// The options of storage.
#[derive(Args)]
pub(crate) struct StorageOptions {
    /// How numbers are stored
    #[arg(long, value_enum, default_value = "f32")]
    storage: Storage,
    /// With --storage clustered: as many clusters at most, 1 to 65536; 1 gives ordinary principal components [default: 128]
    #[arg(long, value_name = "K", value_parser = clusters)]
    clusters: Option<usize>,
    /// With --storage clustered: as many components in each cluster, 0 to 192; 0 gives vector quantization [default: 6]
    #[arg(long, value_name = "N", value_parser = components)]
    components: Option<usize>,
    /// With --storage clustered: as many bits for each weight: 8 or 16 in steps of its range, or 32 [default: 8]
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
    /// Clustered principal components, of 128 clusters and 6 components with weights of 8 bits unless --clusters, --components and
    /// --weights say otherwise
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
                let options = self.compression().options_over(FieldStorage::clustered());
                FieldStorage::Clustered(options)
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
