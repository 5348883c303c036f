//! The light of surfaces, as their shaders take it.

use lobe_env::SceneLight;
use lobe_sh::{Coefficient as _, Expansion as _, Rgb, ShVec, Zonal};

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
    /// All light, then the negative of that of the suns, for transfer with its part without reflections.
    Reflected(usize),
    /// All light, then its negative: what transfer has beside its part without reflections.
    Others(usize),
    /// All light, the suns too.
    Lobe(usize, Zonal),
    /// The radiance of vertices comes from elsewhere.
    Given,
}

impl Lights {
    /// Whether the radiance of vertices comes from elsewhere.
    pub(crate) fn is_given(&self) -> bool {
        self.0.iter().any(|(_, of)| matches!(of, LightUse::Given))
    }

    /// Uploads the expansions of a light, in the world frame, whose suns are apart from them.
    pub(crate) fn update(&self, renderer: &Renderer, light: &SceneLight) -> Result<(), GpuError> {
        let rest = light.rest();
        for (name, of) in &self.0 {
            match of {
                LightUse::Given => {}
                LightUse::Radiance(order) => renderer.update(name, &light_vectors(rest.coefficients(), *order))?,
                LightUse::Irradiance(order) => {
                    let irradiance = rest.convolved(&Zonal::clamped_cosine(*order));
                    renderer.update(name, &light_vectors(irradiance.coefficients(), *order))?;
                }
                LightUse::Reflected(order) => {
                    let less: ShVec<Rgb<f64>> = light.of_suns().map(|c| c.scale(-1.0));
                    let mut vectors = light_vectors(light.whole().coefficients(), *order);
                    vectors.extend(light_vectors(less.coefficients(), *order));
                    renderer.update(name, &vectors)?;
                }
                LightUse::Others(order) => {
                    let whole = light.whole();
                    let mut vectors = light_vectors(whole.coefficients(), *order);
                    vectors.extend(light_vectors(whole.map(|c| c.scale(-1.0)).coefficients(), *order));
                    renderer.update(name, &vectors)?;
                }
                LightUse::Lobe(order, lobe) => {
                    renderer.update(name, &lobe_light(light.whole().coefficients(), lobe, *order))?;
                }
            }
        }
        Ok(())
    }
}
