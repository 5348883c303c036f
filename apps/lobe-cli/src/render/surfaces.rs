//! Surfaces of `lobe render`: the model of reflection, and one finish for all of them.

use anyhow::bail;
use clap::Args;
use lobe::render::{BakedScene, Surfaces};
use lobe::scene::Scene;

use crate::args::values;

/// How surfaces reflect.
#[derive(Args, Default)]
pub(crate) struct SurfaceInput {
    /// The model of reflection: matte, Lambert with the base color as albedo; gltf, the metallic-roughness model with
    /// textures and emission, Smith's masking height-correlated, as renderers have it; gltf-separable, with separable
    /// masking, as the specification of glTF prints it [default: matte, as in a bake; of maps gltf]
    #[arg(long, value_name = "MODEL")]
    surfaces: Option<Surfaces>,
    /// With gltf: this roughness of all surfaces, 0 (mirrors) to 1, in place of their own
    #[arg(long, value_name = "R", value_parser = part)]
    roughness: Option<f32>,
    /// With gltf: all surfaces as metals (1), as plastics (0) or between them, in place of their own
    #[arg(long, value_name = "M", value_parser = part)]
    metallic: Option<f32>,
}

fn part(text: &str) -> Result<f32, String> {
    match values::finite(text)? {
        x if (0.0..=1.0).contains(&x) => Ok(x as f32),
        x => Err(format!("expected a number from 0 to 1, found {x}")),
    }
}

impl SurfaceInput {
    /// The model that is asked for, or that of the mode.
    pub(crate) fn model(&self, default: Surfaces) -> Surfaces {
        self.surfaces.unwrap_or(default)
    }

    /// Refuses what would be ignored: a finish of matte surfaces.
    pub(crate) fn check(&self, default: Surfaces) -> anyhow::Result<()> {
        if let (Surfaces::Matte, Some(option)) = (self.model(default), self.finish()) {
            bail!("{option}: matte surfaces have none; ask for --surfaces gltf, or leave the option out");
        }
        Ok(())
    }

    /// Refuses a finish of a scene that moves.
    pub(crate) fn expect_own_finish(&self, name: &str) -> anyhow::Result<()> {
        let Some(option) = self.finish() else { return Ok(()) };
        bail!("{option}: only of a scene that stands still, but {name} moves; leave the option out");
    }

    /// Whether nobody asked for a model.
    pub(crate) fn is_left_open(&self) -> bool {
        self.surfaces.is_none()
    }

    /// The scene with the finish that is asked for.
    pub(crate) fn applied(&self, scene: Scene) -> anyhow::Result<Scene> {
        Ok(scene.with_finish(self.roughness, self.metallic)?)
    }

    /// The baked scene with the finish that is asked for.
    pub(crate) fn applied_to_baked(&self, baked: BakedScene) -> anyhow::Result<BakedScene> {
        Ok(baked.with_finish(self.roughness, self.metallic)?)
    }

    /// The option of a finish that is given, if any.
    fn finish(&self) -> Option<&'static str> {
        self.roughness.map(|_| "--roughness").or(self.metallic.map(|_| "--metallic"))
    }
}
