//! Finishing of a lightmap: its options, and its steps in their order.

use derive_setters::Setters;
use lobe_scene::Scene;

use crate::error::PrtError;
use crate::finishing::denoise::denoised;
use crate::finishing::seams::Seams;
use crate::finishing::stitch::stitched;
use crate::receivers::charts::charts;
use crate::receivers::lightmap::Lightmap;
use crate::receivers::texel_receivers::TexelReceivers;
use crate::transfer::transfer::Transfer;

/// Options of [`TexelReceivers::finished`].
#[derive(Clone, Debug, PartialEq, Eq, Setters)]
#[non_exhaustive]
pub struct FinishOptions {
    /// Whether neighbors are averaged that differ by their noise alone.
    pub denoise: bool,
    /// Whether charts agree along the edges at which smooth surfaces are cut.
    pub stitch: bool,
}

impl Default for FinishOptions {
    /// Both.
    fn default() -> Self {
        Self { denoise: true, stitch: true }
    }
}

/// A report of [`TexelReceivers::finished`].
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FinishReport {
    /// Edges at which a smooth surface is cut in the lightmap.
    pub seams: usize,
    /// The largest step of the constant coefficient across one of them, as a part of its mean, before stitching.
    pub step_before: f64,
    /// The same after stitching.
    pub step: f64,
}

impl FinishOptions {
    /// Whether anything is to be done.
    #[must_use]
    pub fn is_asked(&self) -> bool {
        self.denoise || self.stitch
    }
}

impl TexelReceivers {
    /// The most bytes that finishing takes for each number of the transfer: it, what is made of it, and at the borders
    /// of charts what is looked for.
    pub const BYTES_TO_FINISH: u64 = 12;

    /// The transfer of these receivers, without noise and without steps at seams as far as the options say.
    ///
    /// First, texels are averaged with those around them in their chart whose difference the noise explains. Then the
    /// texels at the two sides of each edge at which the charts cut a smooth surface are changed as little as it takes,
    /// so that light between texels is the same from both.
    ///
    /// # Errors
    /// [`PrtError::Invalid`] if the transfer is of another number of receivers, or the scene is not theirs.
    pub fn finished(
        &self,
        scene: &Scene,
        transfer: Transfer,
        options: &FinishOptions,
    ) -> Result<(Transfer, FinishReport), PrtError> {
        self.expect_receivers(transfer.receivers())?;
        let charts = charts(scene);
        let transfer = if options.denoise { denoised(self, &charts, &transfer)? } else { transfer };
        if !options.stitch {
            return Ok((transfer, FinishReport::default()));
        }
        let lightmap = Lightmap::of(self, &charts);
        let seams = Seams::new(scene, self, &lightmap);
        let step_before = seams.largest_step(&transfer);
        let transfer = stitched(&seams, &transfer)?;
        let report = FinishReport { seams: seams.edges(), step_before, step: seams.largest_step(&transfer) };
        Ok((transfer, report))
    }
}
