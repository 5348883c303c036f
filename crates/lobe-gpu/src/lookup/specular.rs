//! Split-sum specular reflection on the device.

use lobe_env::DfgTable;

use crate::error::GpuError;
use crate::lookup::environment::Environment;
use crate::renderer::renderer::Renderer;

/// Reflection of GGX microfacets by the split-sum approximation: `g(r) (F₀ A + B)`.
///
/// `g` is a prefiltered environment ([`Environment::of_levels`]), looked up at the level of the roughness; A and B are
/// those of a [`DfgTable`].
#[derive(Clone, Debug)]
pub struct SplitSum {
    /// The levels of the prefiltered environment.
    pub environment: Environment,
    /// Scale and bias.
    pub dfg: DfgTable,
}

impl SplitSum {
    /// Uploads a table as texture `name`.
    pub(crate) fn add_dfg_to(dfg: &DfgTable, renderer: &mut Renderer, name: &str) -> Result<(), GpuError> {
        let texels: Vec<[f32; 4]> =
            dfg.texels().iter().map(|dfg| [dfg.scale as f32, dfg.bias as f32, 0.0, 0.0]).collect();
        renderer.upload_texture(name, [dfg.size() as u32; 2], wgpu::TextureFormat::Rgba32Float, &texels)
    }
}
