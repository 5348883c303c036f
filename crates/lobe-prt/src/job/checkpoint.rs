//! Checkpoints of bakes: the finished chunks on disk.

use std::path::Path;

use lobe_io::{Fingerprint, RecordFile, RecordFormat};

use crate::PrtError;
use crate::job::chunks::{Chunk, Estimator, Sink, Tally};
use crate::job::row_layout::RowLayout;
use crate::job::stored_rows::StoredRows;

/// Checkpoints of bakes among those of Lobe. The version is that of [`RowLayout`].
const FORMAT: RecordFormat =
    RecordFormat { kind: *b"PART", version: 1, work: "bake", arguments: "the scene, the receivers or the options" };

/// The chunks of a bake that are done, a [record](RowLayout) for each.
#[derive(Debug)]
pub(crate) struct Checkpoint {
    records: RecordFile,
    layout: RowLayout,
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
    ) -> Result<Self, PrtError> {
        let layout = RowLayout::of(estimator, bounces);
        fingerprint.word(bounces as u64);
        let mut tally = Tally { energy: vec![0.0; bounces + 1], ..Tally::default() };
        let take_up = |record: &[u8]| tally += &layout.tally(record);
        let records = RecordFile::open(path, &FORMAT, layout.records(), &fingerprint, take_up)?;
        Ok(Self { records, layout, tally })
    }

    /// All that was found, when all is done. The rows stay where they are.
    pub(crate) fn finish(self) -> Result<(Tally, StoredRows), PrtError> {
        Ok((self.tally, StoredRows::new(self.records.into_reader()?, self.layout)))
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
