//! Checkpoints of bakes: the finished chunks on disk, and their rows, which stay there when the bake is done.

use std::io;
use std::path::Path;

use lobe_io::{Fingerprint, IoError, RecordFile, RecordFormat, RecordLayout, RecordReader, Shard};

use crate::error::PrtError;
use crate::job::chunks::{Chunk, Chunks, Estimator, Sink, Tally};

/// Checkpoints of bakes among those of Lobe. The version is that of [`RowLayout`].
const FORMAT: RecordFormat =
    RecordFormat { kind: *b"PART", version: 1, work: "bake", arguments: "the scene, the receivers or the options" };

/// The chunks of a bake or of a shard of it that are done, a [record](RowLayout) for each.
#[derive(Debug)]
pub(crate) struct Checkpoint {
    records: RecordFile,
    layout: RowLayout,
    shard: Shard,
    /// The sums over the chunks that are done.
    tally: Tally,
}

impl Checkpoint {
    /// Opens the checkpoint of a bake, or makes one of its final size.
    ///
    /// # Errors
    /// [`PrtError::Io`] if it cannot be written or the disk has no room for all of it; [`PrtError::Invalid`] if it is
    /// that of another bake, or none, or in use.
    pub(crate) fn open<E: Estimator>(
        path: &Path,
        estimator: &E,
        mut fingerprint: Fingerprint,
        bounces: usize,
        shard: Option<Shard>,
    ) -> Result<Self, PrtError> {
        let layout = RowLayout::of(estimator, bounces);
        fingerprint.word(bounces as u64);
        let mut tally = Tally { energy: vec![0.0; bounces + 1], ..Tally::default() };
        let take_up = |record: &[u8]| tally += &layout.tally(record);
        let records = RecordFile::open(path, &FORMAT, layout.records(), &fingerprint, shard, take_up)?;
        Ok(Self { records, layout, shard: shard.unwrap_or(Shard::WHOLE), tally })
    }

    /// The sums of what was found, when everything is on the disk.
    pub(crate) fn close(mut self) -> Result<Tally, PrtError> {
        self.sync()?;
        Ok(self.tally)
    }

    /// All that was found, when all is done. The rows stay where they are.
    pub(crate) fn finish(self) -> Result<(Tally, StoredRows), PrtError> {
        Ok((self.tally, StoredRows { records: self.records.into_reader()?, layout: self.layout }))
    }

    /// Waits until everything is on the disk.
    pub(crate) fn sync(&mut self) -> Result<(), PrtError> {
        Ok(self.records.sync()?)
    }
}

impl Sink for Checkpoint {
    fn done(&self) -> usize {
        self.records.done()
    }

    fn shard(&self) -> Shard {
        self.shard
    }

    fn push(&mut self, chunk: Chunk) -> Result<(), PrtError> {
        if let Some(at) = chunk.rows.iter().position(|c| !c.is_finite()) {
            let receiver = self.layout.receiver(self.done(), at);
            let message = format!("expected finite coefficients, found {} at receiver {receiver}", chunk.rows[at]);
            return Err(PrtError::invalid("transfer", message));
        }
        self.tally += &chunk.tally;
        Ok(self.records.push(self.layout.encode(&chunk))?)
    }
}

/// The records of a bake's chunks.
///
/// ```text
///   record:  rays (u64), left, energy of each bounce (f64), rows (f32)
/// ```
///
/// All numbers are little-endian; the sums are those of [`Tally`].
#[derive(Clone, Copy, Debug)]
struct RowLayout {
    chunks: Chunks,
    row: usize,
    energies: usize,
}

impl RowLayout {
    fn of<E: Estimator>(estimator: &E, bounces: usize) -> Self {
        Self { chunks: Chunks::of(estimator), row: estimator.row(), energies: bounces + 1 }
    }

    /// The layout of the records in a file.
    fn records(&self) -> RecordLayout {
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
    fn offset_of_row(&self, receiver: usize) -> u64 {
        let size = self.chunks.size();
        self.records().offset(receiver / size) + (self.before_rows() + 4 * self.row * (receiver % size)) as u64
    }

    /// The number of receivers from this one on whose rows are contiguous.
    fn run_from(&self, receiver: usize) -> usize {
        self.chunks.range(receiver / self.chunks.size()).end - receiver
    }

    /// The receiver of a number among the rows of a chunk.
    fn receiver(&self, chunk: usize, number: usize) -> usize {
        self.chunks.range(chunk).start + number / self.row
    }

    /// The length of a row.
    fn row(&self) -> usize {
        self.row
    }

    fn receivers(&self) -> usize {
        self.chunks.receivers()
    }

    /// The record of a chunk.
    fn encode(&self, chunk: &Chunk) -> Vec<u8> {
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
    fn tally(&self, record: &[u8]) -> Tally {
        let numbers = record[..self.before_rows()].as_chunks::<8>().0;
        let energy = numbers[2..].iter().map(|b| f64::from_le_bytes(*b)).collect();
        Tally { rays: u64::from_le_bytes(numbers[0]), left: f64::from_le_bytes(numbers[1]), energy }
    }
}

/// The number of numbers in memory at a time while results go from one file to another: 4 MiB, or one row that is
/// longer.
const NUMBERS_AT_ONCE: usize = 1 << 20;

/// The number of rows of this length in memory at a time.
pub(crate) fn rows_at_once(row: usize) -> usize {
    (NUMBERS_AT_ONCE / row).max(1)
}

/// The rows of all receivers of a bake that is done. Its file stays locked as long as this is there.
#[derive(Debug)]
pub(crate) struct StoredRows {
    records: RecordReader,
    layout: RowLayout,
}

impl StoredRows {
    /// The number of rows.
    pub(crate) fn count(&self) -> usize {
        self.layout.receivers()
    }

    /// The rows from `first` on, as many as fill `rows`.
    pub(crate) fn read_into(&self, first: usize, rows: &mut [f32]) -> io::Result<()> {
        let row = self.layout.row();
        let end = first + rows.len() / row;
        if first >= end {
            return Ok(());
        }
        let start = self.layout.offset_of_row(first);
        let mut bytes = vec![0; (self.layout.offset_of_row(end - 1) - start) as usize + 4 * row];
        self.records.read_exact_at(start, &mut bytes)?;
        let (mut receiver, mut rest) = (first, rows);
        while receiver < end {
            let count = self.layout.run_from(receiver).min(end - receiver);
            let (now, later) = rest.split_at_mut(count * row);
            let at = (self.layout.offset_of_row(receiver) - start) as usize;
            let numbers = bytes[at..at + 4 * now.len()].as_chunks::<4>().0;
            now.iter_mut().zip(numbers).for_each(|(number, bytes)| *number = f32::from_le_bytes(*bytes));
            (receiver, rest) = (receiver + count, later);
        }
        Ok(())
    }

    /// The file that they are in.
    pub(crate) fn path(&self) -> &Path {
        self.records.path()
    }

    /// All rows.
    pub(crate) fn load(&self) -> Result<Vec<f32>, PrtError> {
        let row = self.layout.row();
        let at_once = rows_at_once(row);
        let mut rows = vec![0.0; self.layout.receivers() * row];
        for (k, rows) in rows.chunks_mut(at_once * row).enumerate() {
            let read = self.read_into(k * at_once, rows);
            read.map_err(|source| IoError::io(self.records.path(), source))?;
        }
        Ok(rows)
    }
}
