//! Transfer and transfer matrices a few receivers at a time, from memory or from disk.

use std::io;

use crate::error::PrtError;
use crate::job::checkpoint::StoredRows;
use crate::transfer::transfer::{Channels, Transfer};
use crate::transfer::transfer_matrices::TransferMatrices;

/// Declares rows of `channels · order^power` numbers: the trait, the type for those in a checkpoint, and the trait for it
/// and for the type in memory.
macro_rules! rows {
    (
        $(#[$rows_doc:meta])* trait $rows:ident of $memory:ident;
        $(#[$count_doc:meta])* $count:ident;
        $(#[$len_doc:meta])* power $power:literal;
        $(#[$stored_doc:meta])* struct $stored:ident;
    ) => {
        $(#[$rows_doc])*
        pub trait $rows {
            /// Number of bands n.
            fn order(&self) -> usize;

            /// The channels: one for all colors, or three.
            fn channels(&self) -> Channels;

            $(#[$count_doc])*
            fn $count(&self) -> usize;

            /// The coefficients from those of number `first` on, as many as fill `rows`: one after the other, channel by
            /// channel, vectors in index order and matrices row by row.
            ///
            /// # Errors
            /// Those of the file.
            fn read_rows(&self, first: usize, rows: &mut [f32]) -> io::Result<()>;

            $(#[$len_doc])*
            fn row_len(&self) -> usize {
                self.channels().count() * self.order().pow($power)
            }
        }

        impl $rows for $memory {
            fn order(&self) -> usize {
                self.order()
            }

            fn channels(&self) -> Channels {
                self.channels()
            }

            fn $count(&self) -> usize {
                self.$count()
            }

            fn read_rows(&self, first: usize, rows: &mut [f32]) -> io::Result<()> {
                let start = first * self.row_len();
                rows.copy_from_slice(&self.coefficients()[start..start + rows.len()]);
                Ok(())
            }
        }

        $(#[$stored_doc])*
        #[derive(Debug)]
        pub struct $stored {
            pub(crate) order: usize,
            pub(crate) channels: Channels,
            pub(crate) rows: StoredRows,
        }

        impl $stored {
            /// All of it in memory.
            ///
            /// # Errors
            /// [`PrtError::Io`] if the file cannot be read.
            pub fn load(&self) -> Result<$memory, PrtError> {
                $memory::new(self.order, self.channels, self.rows.load()?)
            }
        }

        impl $rows for $stored {
            fn order(&self) -> usize {
                self.order
            }

            fn channels(&self) -> Channels {
                self.channels
            }

            fn $count(&self) -> usize {
                self.rows.count()
            }

            fn read_rows(&self, first: usize, rows: &mut [f32]) -> io::Result<()> {
                self.rows.read_into(first, rows)
            }
        }
    };
}

rows! {
    /// The transfer of many receivers, a few of them at a time: of a [`Transfer`], or of a file that holds more than
    /// memory.
    trait TransferRows of Transfer;
    /// Number of receivers.
    receivers;
    /// The number of coefficients of a receiver: `channels · n²`.
    power 2;
    /// Transfer that a bake has left in its checkpoint, which stays locked as long as this is there.
    struct StoredTransfer;
}

rows! {
    /// The transfer matrices of many points, a few of them at a time: of [`TransferMatrices`], or of a file that holds
    /// more than memory. Each matrix is n² × n².
    trait MatrixRows of TransferMatrices;
    /// Number of points.
    points;
    /// The number of coefficients of a point: `channels · n⁴`.
    power 4;
    /// Transfer matrices that a bake has left in its checkpoint, which stays locked as long as this is there.
    struct StoredMatrices;
}
