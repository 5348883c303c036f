//! Split-sum specular reflection on the device.

use lobe_env::{DfgTable, LobeTable, MappedMap, PrefilterOptions, cube_source, prefilter_ggx};
use lobe_io::Job;

use crate::error::GpuError;
use crate::lookup::environment::Environment;
use crate::renderer::renderer::Renderer;

/// The format of tables.
const TABLE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Reflection of GGX microfacets by the split-sum approximation: `g(a) (F₀ A + B)`.
///
/// `g` is a prefiltered environment ([`Environment::of_levels`]), looked up at the level of the roughness about the
/// mean direction `a` of the lobe; `a`, A and B are those of a [`LobeTable`].
#[derive(Clone, Debug)]
pub struct SplitSum {
    /// The levels of the prefiltered environment.
    pub environment: Environment,
    /// Where lobes point, and what they reflect of even light.
    pub lobes: LobeTable,
}

impl SplitSum {
    /// Prefilters a light for shiny surfaces, by cubes of this size ([`PrefilterOptions::of_reflections`]).
    ///
    /// The steps of the job are those of resampling and prefiltering.
    ///
    /// # Errors
    /// [`GpuError::Env`] with the errors of [`prefilter_ggx`].
    pub fn of_light(light: &MappedMap, size: usize, mut job: Job<'_>) -> Result<Self, GpuError> {
        let options = PrefilterOptions::of_reflections(size);
        let levels = prefilter_ggx(&cube_source(light, size, job.reborrow())?, &options, job)?;
        let environment = Environment::of_levels(&levels, options.roughness)?;
        Ok(Self { environment, lobes: LobeTable::correlated() })
    }

    /// Uploads a table as texture `name`.
    pub(crate) fn add_dfg_to(dfg: &DfgTable, renderer: &mut Renderer, name: &str) -> Result<(), GpuError> {
        let texels: Vec<[f32; 4]> =
            dfg.texels().iter().map(|dfg| [dfg.scale as f32, dfg.bias as f32, 0.0, 0.0]).collect();
        renderer.upload_texture(name, [dfg.size() as u32; 2], TABLE, &texels)
    }

    /// Uploads the environment as texture `reflected`, its shape as `reflected shape`, and the table as `lobes`.
    pub(crate) fn add_to(&self, renderer: &mut Renderer) -> Result<(), GpuError> {
        self.environment.add_to(renderer, "reflected")?;
        let texel = |node: &lobe_env::LobeNode| {
            let [scale, bias, lean] = [node.dfg.scale, node.dfg.bias, node.lean].map(|x| x as f32);
            [scale, bias, lean, 0.0]
        };
        let texels: Vec<[f32; 4]> = self.lobes.nodes().iter().map(texel).collect();
        renderer.upload_texture("lobes", [self.lobes.size() as u32; 2], TABLE, &texels)
    }
}
