//! Irradiance on the device, from seven vectors.

use lobe_sh::PackedIrradiance;

use crate::lookup::towards::{Question, colors};
use crate::renderer::kernel::Slot;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::{Context, GpuError};

/// The irradiance of order 3 for unit normals, as [`PackedIrradiance::eval`]; module `irradiance`.
///
/// # Errors
/// [`GpuError::Device`] if the device fails.
pub fn irradiance_towards(
    context: &Context,
    irradiance: &PackedIrradiance,
    normals: &[[f32; 3]],
) -> Result<Vec<[f32; 3]>, GpuError> {
    let mut renderer = Renderer::new(context);
    renderer.uniform("irradiance", &irradiance.to_vectors())?;
    let question = Question {
        name: "irradiance",
        shader: Shader::new(&["dispatch", "irradiance"]),
        reads: &[("irradiance", Slot::Uniform, "var<uniform> irradiance: PackedIrradiance")],
        function: "fn value(i: u32, n: vec3f) -> vec4f { return vec4f(packed_irradiance(irradiance, n), 0.0); }\n",
    };
    question.ask(renderer, normals).map(colors)
}
