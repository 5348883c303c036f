//! The transfer that a baked file holds of some vertices of a part, to be completed.

use lobe_io::Job;
use lobe_prt::{BakeOptions, FittedVertices, Transfer};
use lobe_scene::{Bvh, Scene};

use lobe_render::RenderError;

/// The transfer of the vertices of a still part from a file, and which of them keep it.
#[derive(Clone, Debug)]
pub(crate) struct KeptTransfer {
    pub(crate) transfer: Transfer,
    pub(crate) keeps: Vec<bool>,
    /// Of the bake that the file holds.
    pub(crate) options: BakeOptions,
}

impl KeptTransfer {
    pub(crate) fn order(&self) -> usize {
        self.transfer.order()
    }

    /// The same with the others fitted by the part alone, as the file was.
    pub(crate) fn completed(&self, scene: &Scene, job: Job<'_>) -> Result<Transfer, RenderError> {
        let others: Vec<usize> = (0..self.keeps.len()).filter(|vertex| !self.keeps[*vertex]).collect();
        let mut options = self.options.clone();
        options.channels = Some(self.transfer.channels());
        let (found, _) = FittedVertices::some(scene, &others)?.bake(&Bvh::new(scene), &options, job)?;
        let mut rows = self.transfer.coefficients().to_vec();
        let width = row_width(&self.transfer);
        for (vertex, row) in others.iter().zip(found.coefficients().chunks_exact(width)) {
            rows[vertex * width..][..width].copy_from_slice(row);
        }
        Ok(Transfer::new(self.transfer.order(), self.transfer.channels(), rows)?)
    }
}

pub(crate) fn row_width(transfer: &Transfer) -> usize {
    transfer.order().pow(2) * transfer.channels().count()
}
