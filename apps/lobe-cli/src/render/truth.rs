//! The path tracer of `lobe render`: its options, and a picture by it.

use anyhow::bail;
use clap::{Args, ValueEnum};
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
    /// truth: the model of reflection [default: matte, as in a bake]
    #[arg(long, value_enum)]
    surfaces: Option<SurfaceModel>,
    /// truth: another seed gives other paths [default: 0]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum SurfaceModel {
    /// Lambert with the base color as albedo
    Matte,
    /// The metallic-roughness model of glTF, Smith's masking height-correlated, as renderers have it
    Gltf,
    /// The same with separable masking, as the specification of glTF prints it
    GltfSeparable,
}

impl TruthInput {
    /// The options of a picture of `size`.
    pub(crate) fn options(
        &self,
        (width, height): (usize, usize),
        samples: Option<usize>,
        bounces: usize,
    ) -> TruthOptions {
        let surfaces = match self.surfaces {
            None | Some(SurfaceModel::Matte) => Surfaces::Matte,
            Some(SurfaceModel::Gltf) => Surfaces::MetallicRoughness,
            Some(SurfaceModel::GltfSeparable) => Surfaces::MetallicRoughnessSeparable,
        };
        let paths = PathOptions::default().bounces(bounces).surfaces(surfaces).seed(self.seed.unwrap_or(0));
        let count = SampleCount::of(samples.unwrap_or(PATHS));
        TruthOptions::default().width(width).height(height).count(count).paths(paths)
    }

    /// Refuses the options, of another mode.
    pub(crate) fn refuse(&self) -> anyhow::Result<()> {
        if self.surfaces.is_some() {
            bail!("--surfaces: only of --mode truth; all others are matte; leave the option out");
        }
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
