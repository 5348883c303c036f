//! Transfer and transfer matrices a few receivers at a time, from memory or from disk.

use std::io;

use crate::job::stored_rows::StoredRows;
use crate::{Channels, PrtError, Transfer, TransferMatrices};

/// The transfer of many receivers, a few of them at a time: of a [`Transfer`], or of a file that holds more than
/// memory.
pub trait TransferRows {
    /// Number of bands n.
    fn order(&self) -> usize;

    /// The channels: one vector or three for each receiver.
    fn channels(&self) -> Channels;

    /// Number of receivers.
    fn receivers(&self) -> usize;

    /// The coefficients of the receivers from `first` on, as many as fill `rows`: receiver by receiver, channel by
    /// channel, in index order.
    ///
    /// # Errors
    /// Those of the file.
    fn read_rows(&self, first: usize, rows: &mut [f32]) -> io::Result<()>;

    /// The number of coefficients of a receiver: `channels · n²`.
    fn row_len(&self) -> usize {
        self.channels().count() * self.order() * self.order()
    }
}

impl TransferRows for Transfer {
    fn order(&self) -> usize {
        self.order()
    }

    fn channels(&self) -> Channels {
        self.channels()
    }

    fn receivers(&self) -> usize {
        self.receivers()
    }

    fn read_rows(&self, first: usize, rows: &mut [f32]) -> io::Result<()> {
        let start = first * self.row_len();
        rows.copy_from_slice(&self.coefficients()[start..start + rows.len()]);
        Ok(())
    }
}

/// Transfer that a bake has left in its checkpoint, which stays locked as long as this is there.
#[derive(Debug)]
pub struct StoredTransfer {
    pub(crate) order: usize,
    pub(crate) channels: Channels,
    pub(crate) rows: StoredRows,
}

impl StoredTransfer {
    /// All of it in memory.
    ///
    /// # Errors
    /// [`PrtError::Io`] if the file cannot be read.
    pub fn load(&self) -> Result<Transfer, PrtError> {
        Transfer::new(self.order, self.channels, self.rows.load()?)
    }
}

impl TransferRows for StoredTransfer {
    fn order(&self) -> usize {
        self.order
    }

    fn channels(&self) -> Channels {
        self.channels
    }

    fn receivers(&self) -> usize {
        self.rows.count()
    }

    fn read_rows(&self, first: usize, rows: &mut [f32]) -> io::Result<()> {
        self.rows.read_into(first, rows)
    }
}

/// The transfer matrices of many points, a few of them at a time: of [`TransferMatrices`], or of a file that holds more
/// than memory.
pub trait MatrixRows {
    /// Number of bands n; each matrix is n² × n².
    fn order(&self) -> usize;

    /// The channels: one matrix or three for each point.
    fn channels(&self) -> Channels;

    /// Number of points.
    fn points(&self) -> usize;

    /// The coefficients of the points from `first` on, as many as fill `rows`: point by point, channel by channel, row
    /// by row.
    ///
    /// # Errors
    /// Those of the file.
    fn read_rows(&self, first: usize, rows: &mut [f32]) -> io::Result<()>;

    /// The number of coefficients of a point: `channels · n⁴`.
    fn row_len(&self) -> usize {
        self.channels().count() * self.order().pow(4)
    }
}

impl MatrixRows for TransferMatrices {
    fn order(&self) -> usize {
        self.order()
    }

    fn channels(&self) -> Channels {
        self.channels()
    }

    fn points(&self) -> usize {
        self.points()
    }

    fn read_rows(&self, first: usize, rows: &mut [f32]) -> io::Result<()> {
        let start = first * self.row_len();
        rows.copy_from_slice(&self.coefficients()[start..start + rows.len()]);
        Ok(())
    }
}

/// Transfer matrices that a bake has left in its checkpoint, which stays locked as long as this is there.
#[derive(Debug)]
pub struct StoredMatrices {
    pub(crate) order: usize,
    pub(crate) channels: Channels,
    pub(crate) rows: StoredRows,
}

impl StoredMatrices {
    /// All of them in memory.
    ///
    /// # Errors
    /// [`PrtError::Io`] if the file cannot be read.
    pub fn load(&self) -> Result<TransferMatrices, PrtError> {
        TransferMatrices::new(self.order, self.channels, self.rows.load()?)
    }
}

impl MatrixRows for StoredMatrices {
    fn order(&self) -> usize {
        self.order
    }

    fn channels(&self) -> Channels {
        self.channels
    }

    fn points(&self) -> usize {
        self.rows.count()
    }

    fn read_rows(&self, first: usize, rows: &mut [f32]) -> io::Result<()> {
        self.rows.read_into(first, rows)
    }
}
