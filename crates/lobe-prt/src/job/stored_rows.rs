//! Stored rows: results that stay in the file of a checkpoint.

use std::io;

use lobe_io::RecordReader;

use crate::PrtError;
use crate::job::row_layout::RowLayout;

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
    pub(crate) fn new(records: RecordReader, layout: RowLayout) -> Self {
        Self { records, layout }
    }

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

    /// All rows.
    pub(crate) fn load(&self) -> Result<Vec<f32>, PrtError> {
        let row = self.layout.row();
        let at_once = rows_at_once(row);
        let mut rows = vec![0.0; self.layout.receivers() * row];
        for (k, rows) in rows.chunks_mut(at_once * row).enumerate() {
            let read = self.read_into(k * at_once, rows);
            read.map_err(|source| PrtError::Io { place: self.records.path().display().to_string(), source })?;
        }
        Ok(rows)
    }
}
