//! The path tracer of `lobe render`: its options, and a picture by it.

use anyhow::bail;
use clap::Args;
use lobe::io::Job;
use lobe::render::{
    Camera, DistantLight, Emitter, PathOptions, RenderError, SampleCount, Surfaces, TruthOptions,
    render_truth_with_emitters,
};
use lobe::scene::{Bvh, Scene};

use crate::render::pictures::Rendered;

/// Paths of a pixel without --samples.
const PATHS: usize = 64;

/// What only the truth knows.
#[derive(Args)]
pub(crate) struct TruthInput {
    /// truth: another seed gives other paths [default: 0]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
}

impl TruthInput {
    /// The options of a picture of `size`.
    pub(crate) fn options(
        &self,
        (width, height): (usize, usize),
        samples: Option<usize>,
        bounces: usize,
        surfaces: Surfaces,
    ) -> TruthOptions {
        let paths = PathOptions::default().bounces(bounces).surfaces(surfaces).seed(self.seed.unwrap_or(0));
        let count = SampleCount::of(samples.unwrap_or(PATHS));
        TruthOptions::default().width(width).height(height).count(count).paths(paths)
    }

    /// Refuses the options, of another mode.
    pub(crate) fn refuse(&self) -> anyhow::Result<()> {
        if self.seed.is_some() {
            bail!("--seed: only --mode truth is random; leave the option out");
        }
        Ok(())
    }
}

/// A picture traced by paths.
pub(crate) fn traced(
    (scene, bvh): (&Scene, &Bvh),
    (distant, emitters): (&DistantLight, &[Emitter]),
    camera: &Camera,
    options: &TruthOptions,
    job: Job<'_>,
) -> Result<Rendered, RenderError> {
    let truth = render_truth_with_emitters(scene, bvh, camera, distant, emitters, options, job)?;
    Ok(Rendered::Traced(Box::new(truth)))
}
