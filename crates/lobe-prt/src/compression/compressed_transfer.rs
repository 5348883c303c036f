//! Transfer compressed by clustered principal components.

use lobe_io::Job;
use lobe_sh::Rgb;

use crate::compression::compress::{CompressOptions, CompressReport, compress_table};
use crate::compression::compressed_table::CompressedTable;
use crate::error::PrtError;
use crate::transfer::transfer::check_order;
use crate::transfer::transfer::{Channels, Transfer};

/// Transfer vectors as a few weights for each receiver and a few vectors for each cluster of receivers.
///
/// ```text
///   T ≈ M_k + Σ_j w_j B_kj        B = M_k·L + Σ_j w_j (B_kj·L)
/// ```
///
/// Under a light the scalar products in brackets are formed once for every cluster, `n' + 1` of them; a receiver then
/// takes `n'` multiplications and additions, whatever the order (the form in which D3DX uses [Sloan 2003]).
#[derive(Clone, Debug, PartialEq)]
pub struct CompressedTransfer {
    order: usize,
    channels: Channels,
    table: CompressedTable,
}

impl CompressedTransfer {
    /// Compresses; see [`compress_table`]. The vectors of red, green and blue are one row.
    ///
    /// # Errors
    /// [`PrtError::Options`] for options out of range or a job that is to be kept in a file, [`PrtError::Cancelled`] if
    /// the job was told to stop.
    pub fn new(
        transfer: &Transfer,
        options: &CompressOptions,
        job: Job<'_>,
    ) -> Result<(Self, CompressReport), PrtError> {
        let (order, channels) = (transfer.order(), transfer.channels());
        let (table, report) = compress_table(transfer.coefficients(), width(order, channels), options, job)?;
        Ok((Self { order, channels, table }, report))
    }

    /// From a table of rows of `order² · channels` numbers.
    ///
    /// # Errors
    /// [`PrtError::Options`] if the order is not 1 to 8; [`PrtError::Invalid`] if the rows have another width.
    pub fn from_table(order: usize, channels: Channels, table: CompressedTable) -> Result<Self, PrtError> {
        check_order(order)?;
        let (expected, found) = (width(order, channels), table.width());
        if expected != found {
            let message = format!("expected vectors of {expected} numbers, found {found}");
            return Err(PrtError::invalid("compressed transfer", message));
        }
        Ok(Self { order, channels, table })
    }

    /// Number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The channels: one vector or three for each receiver.
    #[must_use]
    pub fn channels(&self) -> Channels {
        self.channels
    }

    /// Number of receivers.
    #[must_use]
    pub fn receivers(&self) -> usize {
        self.table.rows()
    }

    /// Clusters, weights and vectors.
    #[must_use]
    pub fn table(&self) -> &CompressedTable {
        &self.table
    }

    /// The transfer of one receiver, channel by channel.
    ///
    /// # Panics
    /// If there is no such receiver.
    #[must_use]
    pub fn decode(&self, receiver: usize) -> Vec<f32> {
        let mut out = vec![0.0; self.table.width()];
        self.table.decode_into(receiver, &mut out);
        out
    }

    /// The transfer of all receivers.
    #[must_use]
    pub fn to_transfer(&self) -> Transfer {
        Transfer::new(self.order, self.channels, self.table.decode())
            .unwrap_or_else(|e| unreachable!("finite vectors with finite weights: {e}"))
    }

    /// The exit radiance of every receiver under a light, as [`Transfer::exit_radiance`] has it.
    ///
    /// # Panics
    /// If the light has no coefficients.
    #[must_use]
    pub fn exit_radiance(&self, light: &[Rgb<f64>]) -> Vec<Rgb<f32>> {
        let mut out = vec![Rgb::new(0.0, 0.0, 0.0); self.receivers()];
        self.exit_radiance_into(light, &mut out);
        out
    }

    /// [`CompressedTransfer::exit_radiance`] without an allocation for every receiver.
    ///
    /// # Panics
    /// If the light has no coefficients, or `out` has not one place for each receiver.
    pub fn exit_radiance_into(&self, light: &[Rgb<f64>], out: &mut [Rgb<f32>]) {
        assert!(!light.is_empty(), "a light has at least one coefficient");
        let n = self.order * self.order;
        let of_light = |l: &Rgb<f64>, c: usize| [l.r, l.g, l.b][c];
        let color = |vector: &[f32]| {
            [0, 1, 2].map(|c| {
                let channel = &vector[c.min(self.channels.count() - 1) * n..][..n];
                channel.iter().zip(light).map(|(t, l)| f64::from(*t) * of_light(l, c)).sum()
            })
        };
        self.table.colors_into(color, out);
    }
}

fn width(order: usize, channels: Channels) -> usize {
    order * order * channels.count()
}
