//! The layout of a chunk's record in a checkpoint.

use lobe_io::RecordLayout;

use crate::job::chunks::{Chunk, Chunks, Estimator, Tally};

/// The records of a bake's chunks.
///
/// ```text
///   record:  rays (u64), left, energy of each bounce (f64), rows (f32)
/// ```
///
/// All numbers are little-endian; the sums are those of [`Tally`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowLayout {
    chunks: Chunks,
    row: usize,
    energies: usize,
}

impl RowLayout {
    pub(crate) fn of<E: Estimator>(estimator: &E, bounces: usize) -> Self {
        Self { chunks: Chunks::of(estimator), row: estimator.row(), energies: bounces + 1 }
    }

    /// The layout of the records in a file.
    pub(crate) fn records(&self) -> RecordLayout {
        let count = self.chunks.count();
        let bytes = |receivers| self.before_rows() + 4 * self.row * receivers;
        let last = self.chunks.range(count - 1).len();
        RecordLayout { count, bytes: bytes(self.chunks.size()), last: bytes(last) }
    }

    /// Bytes of a record before its rows.
    fn before_rows(&self) -> usize {
        16 + 8 * self.energies
    }

    /// The offset of the row of a receiver in the file.
    pub(crate) fn offset_of_row(&self, receiver: usize) -> u64 {
        let size = self.chunks.size();
        self.records().offset(receiver / size) + (self.before_rows() + 4 * self.row * (receiver % size)) as u64
    }

    /// The number of receivers from this one on whose rows are contiguous.
    pub(crate) fn run_from(&self, receiver: usize) -> usize {
        self.chunks.range(receiver / self.chunks.size()).end - receiver
    }

    /// The receiver of a number among the rows of a chunk.
    pub(crate) fn receiver(&self, chunk: usize, number: usize) -> usize {
        self.chunks.range(chunk).start + number / self.row
    }

    /// The length of a row.
    pub(crate) fn row(&self) -> usize {
        self.row
    }

    pub(crate) fn receivers(&self) -> usize {
        self.chunks.receivers()
    }

    /// The record of a chunk.
    pub(crate) fn encode(&self, chunk: &Chunk) -> Vec<u8> {
        let Chunk { tally, rows } = chunk;
        // Room for the checksum, too.
        let mut bytes = Vec::with_capacity(self.before_rows() + 4 * rows.len() + 8);
        bytes.extend(tally.rays.to_le_bytes());
        bytes.extend(tally.left.to_le_bytes());
        (0..self.energies).for_each(|b| bytes.extend(tally.energy.get(b).copied().unwrap_or(0.0).to_le_bytes()));
        rows.iter().for_each(|t| bytes.extend(t.to_le_bytes()));
        bytes
    }

    /// The sums of a record.
    pub(crate) fn tally(&self, record: &[u8]) -> Tally {
        let numbers = record[..self.before_rows()].as_chunks::<8>().0;
        let energy = numbers[2..].iter().map(|b| f64::from_le_bytes(*b)).collect();
        Tally { rays: u64::from_le_bytes(numbers[0]), left: f64::from_le_bytes(numbers[1]), energy }
    }
}
