//! Split-sum specular reflection on the device.

use lobe_env::DfgTable;

use crate::lookup::environment::Environment;
use crate::lookup::towards::{Question, colors};
use crate::renderer::kernel::Slot;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::{Context, GpuError};

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
    /// The radiance towards the eye of surfaces with these unit normals, seen from these unit directions, of one roughness
    /// `√α` and one reflectance along the normal; module `specular`.
    ///
    /// # Errors
    /// [`GpuError::Options`] if there are not as many directions as normals; else as [`Environment::radiance_towards`].
    pub fn reflected_towards(
        &self,
        context: &Context,
        normals: &[[f32; 3]],
        views: &[[f32; 3]],
        roughness: f32,
        f0: [f32; 3],
    ) -> Result<Vec<[f32; 3]>, GpuError> {
        if normals.len() != views.len() {
            let message = format!("expected a view for each of {} normals, found {}", normals.len(), views.len());
            return Err(GpuError::Options(message));
        }
        let mut renderer = Renderer::new(context);
        self.environment.add_to(&mut renderer, "environment")?;
        Self::add_dfg_to(&self.dfg, &mut renderer, "dfg")?;
        renderer.uniform("surface", &[f0[0], f0[1], f0[2], roughness])?;
        let views: Vec<[f32; 4]> = views.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect();
        renderer.upload("views", &views)?;
        let question = Question {
            name: "specular",
            shader: self.environment.constants(Shader::new(&["dispatch", "specular"])),
            reads: &[
                ("environment", Slot::Texture, "var texels: texture_2d<f32>"),
                ("environment shape", Slot::Uniform, "var<uniform> shape: Environment"),
                ("dfg", Slot::Texture, "var dfg: texture_2d<f32>"),
                ("surface", Slot::Uniform, "var<uniform> surface: vec4f"),
                ("views", Slot::Read, "var<storage, read> views: array<vec4f>"),
            ],
            function: "fn value(i: u32, n: vec3f) -> vec4f {
    return vec4f(split_sum(texels, shape, dfg, n, views[i].xyz, surface.w, surface.rgb), 0.0);
}
",
        };
        question.ask(renderer, normals).map(colors)
    }

    /// Uploads a table as texture `name`.
    pub(crate) fn add_dfg_to(dfg: &DfgTable, renderer: &mut Renderer, name: &str) -> Result<(), GpuError> {
        let texels: Vec<[f32; 4]> =
            dfg.texels().iter().map(|dfg| [dfg.scale as f32, dfg.bias as f32, 0.0, 0.0]).collect();
        renderer.upload_texture(name, [dfg.size() as u32; 2], wgpu::TextureFormat::Rgba32Float, &texels)
    }
}
