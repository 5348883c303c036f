//! Transfer of the texels of a lightmap that need not be in memory.

use std::io;

use crate::transfer::transfer::Channels;
use crate::transfer::transfer_rows::TransferRows;

/// Receivers between two that are wanted are read with them if they are no more than this: cheaper than to look for the
/// second place in the file.
const GAP: usize = 64;

/// The transfer of every texel of a lightmap, row by row: that of the receiver which it shows.
pub struct TexelRows<'a> {
    /// The receiver of each texel.
    shown: Vec<u32>,
    receivers: &'a dyn TransferRows,
}

impl<'a> TexelRows<'a> {
    pub(crate) fn new(shown: Vec<u32>, receivers: &'a dyn TransferRows) -> Self {
        Self { shown, receivers }
    }
}

impl TransferRows for TexelRows<'_> {
    fn order(&self) -> usize {
        self.receivers.order()
    }

    fn channels(&self) -> Channels {
        self.receivers.channels()
    }

    /// The number of texels.
    fn receivers(&self) -> usize {
        self.shown.len()
    }

    fn read_rows(&self, first: usize, rows: &mut [f32]) -> io::Result<()> {
        let len = self.row_len();
        let texels = &self.shown[first..first + rows.len() / len];
        let mut wanted: Vec<_> =
            texels.iter().enumerate().map(|(texel, &receiver)| (receiver as usize, texel)).collect();
        wanted.sort_unstable();
        let (mut rest, mut buffer) = (&wanted[..], Vec::new());
        while let Some(&(start, _)) = rest.first() {
            // Together they are no more than was asked for, and some gaps.
            let gaps =
                rest.windows(2).take_while(|pair| pair[1].0 - pair[0].0 <= GAP && pair[1].0 - start < texels.len());
            let (run, later) = rest.split_at(1 + gaps.count());
            let end = run[run.len() - 1].0 + 1;
            buffer.resize((end - start) * len, 0.0);
            self.receivers.read_rows(start, &mut buffer)?;
            for &(receiver, texel) in run {
                rows[texel * len..][..len].copy_from_slice(&buffer[(receiver - start) * len..][..len]);
            }
            rest = later;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::transfer::Transfer;
    use lobe_testkit::Random;

    #[test]
    fn every_texel_has_the_row_of_its_receiver_however_they_are_read() {
        let mut random = Random::new(1);
        let (receivers, texels) = (5000, 3000);
        let numbers = (0..receivers * 4).map(|i| i as f32).collect();
        let transfer = Transfer::new(2, Channels::Gray, numbers).unwrap();
        // Neighbors, repetitions, and jumps to and fro.
        let mut shown: Vec<u32> = (0..1000).map(|t| t / 2).collect();
        shown.extend((1000..texels).map(|_| (random.unit() * receivers as f64) as u32));
        let rows = TexelRows::new(shown.clone(), &transfer);
        assert_eq!((rows.receivers(), rows.row_len()), (texels, 4), "size");
        for at_once in [1, 7, 500, texels] {
            for first in (0..texels).step_by(at_once) {
                let mut found = vec![f32::NAN; 4 * at_once.min(texels - first)];
                rows.read_rows(first, &mut found).unwrap();
                for (k, row) in found.chunks(4).enumerate() {
                    let expected = transfer.vector(shown[first + k] as usize, 0);
                    assert_eq!(row, expected, "texel {}, {at_once} at once", first + k);
                }
            }
        }
    }
}
