//! The path tracer of `lobe render`: its options, and a picture by it.

use lobe::io::Job;
use lobe::render::{
    Camera, DistantLight, Emitter, PathOptions, RenderError, SampleCount, Surfaces, TruthOptions,
    render_truth_with_emitters,
};
use lobe::scene::{Bvh, Scene};

use crate::render::pictures::Rendered;

/// Paths of a pixel without --samples.
const PATHS: usize = 64;

/// The options of a picture of `size`, with so many bounces, by paths of a seed.
pub(crate) fn options(
    (width, height): (usize, usize),
    samples: Option<usize>,
    (bounces, seed): (usize, u64),
    surfaces: Surfaces,
) -> TruthOptions {
    let paths = PathOptions::default().bounces(bounces).surfaces(surfaces).seed(seed);
    let count = SampleCount::of(samples.unwrap_or(PATHS));
    TruthOptions::default().width(width).height(height).count(count).paths(paths)
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
