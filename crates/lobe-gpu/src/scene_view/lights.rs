//! The light of surfaces, as their shaders take it.

use lobe_sh::{Expansion as _, Rgb, ShVec, Zonal};

use crate::error::GpuError;
use crate::renderer::renderer::Renderer;
use crate::transfer::matrix_passes::lobe_light;
use crate::transfer::vector_passes::light_vectors;

/// What becomes of the light before it is uploaded: each for the uniform of this name.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lights(pub(crate) Vec<(String, LightUse)>);

#[derive(Clone, Debug)]
pub(crate) enum LightUse {
    Radiance(usize),
    Irradiance(usize),
    Lobe(usize, Zonal),
    /// The radiance of vertices comes from elsewhere.
    Given,
}

impl Lights {
    /// Whether the radiance of vertices comes from elsewhere.
    pub(crate) fn is_given(&self) -> bool {
        self.0.iter().any(|(_, of)| matches!(of, LightUse::Given))
    }

    /// Uploads an expansion of the radiance of the surroundings, in the world frame.
    pub(crate) fn update(&self, renderer: &Renderer, light: &ShVec<Rgb<f64>>) -> Result<(), GpuError> {
        for (name, of) in &self.0 {
            match of {
                LightUse::Given => {}
                LightUse::Radiance(order) => renderer.update(name, &light_vectors(light.coefficients(), *order))?,
                LightUse::Irradiance(order) => {
                    let irradiance = light.convolved(&Zonal::clamped_cosine(*order));
                    renderer.update(name, &light_vectors(irradiance.coefficients(), *order))?;
                }
                LightUse::Lobe(order, lobe) => {
                    renderer.update(name, &lobe_light(light.coefficients(), lobe, *order))?;
                }
            }
        }
        Ok(())
    }
}
