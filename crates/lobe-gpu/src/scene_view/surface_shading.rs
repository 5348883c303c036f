//! Ways to light surfaces.

use lobe_env::DfgTable;
use lobe_prt::{CompressedTransfer, GlossyLobe, Lightmap, Transfer, TransferMatrices};
use lobe_scene::Scene;
use lobe_sh::{Expansion as _, Rgb, ShVec, Zonal, convolved};

use crate::lookup::basis::check_order;
use crate::lookup::specular::SplitSum;
use crate::renderer::kernel::Slot;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::transfer::gpu_matrices::{add_incident, lobe_light};
use crate::transfer::gpu_transfer::{add_clustered, add_light, add_transfer, light_vectors};
use crate::{GpuError, Storage};

/// What lights the surfaces of a scene.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum SurfaceShading<'a> {
    /// Irradiance of normals, without shadows, under light of this order, 1 to 8.
    Irradiance(usize),
    /// Transfer vectors at vertices.
    Vertices(&'a Transfer, Storage),
    /// Transfer in clusters, at vertices.
    Clusters(&'a CompressedTransfer),
    /// Transfer vectors at the texels of a lightmap.
    Lightmap(&'a Transfer, &'a Lightmap, Storage),
    /// Transfer matrices at vertices, and the lobe of the reflection.
    Glossy(&'a TransferMatrices, GlossyLobe, Storage),
    /// The radiance of each vertex, computed elsewhere, such as by what moves; [set](crate::SceneView::set_radiance) anew as often as
    /// it changes. The light is not used.
    Radiance(&'a [Rgb<f32>]),
    /// Microfacets of one roughness `√α` that reflect a prefiltered environment, without shadows, with the base color as reflectance
    /// along the normal.
    Specular(&'a SplitSum, f64),
}

/// The shading of a scene after its passes were added.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    /// To be drawn with, and what it binds after the surface.
    pub(crate) shader: Shader,
    pub(crate) reads: Vec<(&'static str, Slot)>,
    /// Whether all that counts is the radiance of vertices.
    pub(crate) is_of_vertices: bool,
    light: LightUse,
}

/// What becomes of the light before it is uploaded.
#[derive(Clone, Debug)]
enum LightUse {
    None,
    Radiance(usize),
    Irradiance(usize),
    Lobe(usize, Zonal),
}

impl SurfaceShading<'_> {
    /// Adds what has to be done before surfaces are drawn.
    pub(crate) fn prepare(&self, renderer: &mut Renderer, scene: &Scene) -> Result<Prepared, GpuError> {
        match *self {
            Self::Irradiance(order) => {
                check_order(order)?;
                add_light(renderer, order)?;
                let shader = Shader::new(&["shade_irradiance"]).order(order);
                let reads = vec![("light", Slot::Uniform)];
                Ok(Prepared { shader, reads, is_of_vertices: false, light: LightUse::Irradiance(order) })
            }
            Self::Vertices(transfer, storage) => {
                expect("vertices", scene.vertex_count(), transfer.receivers())?;
                add_transfer(renderer, transfer, storage, "radiance")?;
                Ok(of_vertices(transfer.order()))
            }
            Self::Clusters(transfer) => {
                expect("vertices", scene.vertex_count(), transfer.receivers())?;
                add_clustered(renderer, transfer, "radiance")?;
                Ok(of_vertices(transfer.order()))
            }
            Self::Lightmap(transfer, lightmap, storage) => {
                expect("texels", lightmap.width().pow(2), transfer.receivers())?;
                add_transfer(renderer, transfer, storage, "radiance")?;
                let charts: Vec<u32> =
                    lightmap.charts_of_texels().iter().chain(lightmap.charts_of_triangles()).copied().collect();
                renderer.upload("charts", &charts)?;
                let shader = Shader::new(&["shade_lightmap"]);
                let reads = vec![("radiance", Slot::Read), ("charts", Slot::Read)];
                Ok(Prepared { shader, reads, is_of_vertices: false, light: LightUse::Radiance(transfer.order()) })
            }
            Self::Glossy(matrices, lobe, storage) => {
                expect("vertices", scene.vertex_count(), matrices.points())?;
                add_incident(renderer, matrices, storage)?;
                let (is_ggx, roughness) = match lobe {
                    GlossyLobe::Phong(_) => (0.0, 0.0),
                    GlossyLobe::Ggx(alpha) => (1.0, alpha.sqrt() as f32),
                };
                renderer.uniform("gloss", &[is_ggx, roughness, 0.0, 0.0])?;
                SplitSum::add_dfg_to(&DfgTable::default(), renderer, "dfg")?;
                let order = matrices.order();
                let shader = Shader::new(&["shade_glossy"]).order(order);
                let reads = vec![("incident", Slot::Read), ("gloss", Slot::Uniform), ("dfg", Slot::Texture)];
                Ok(Prepared { shader, reads, is_of_vertices: false, light: LightUse::Lobe(order, lobe.zonal(order)) })
            }
            Self::Radiance(values) => {
                expect_values(scene.vertex_count(), values.len())?;
                renderer.upload("radiance", &vectors(values))?;
                let reads = vec![("radiance", Slot::Read)];
                let shader = Shader::new(&["shade_vertices"]);
                Ok(Prepared { shader, reads, is_of_vertices: true, light: LightUse::None })
            }
            Self::Specular(split, roughness) => {
                split.environment.add_to(renderer, "reflected")?;
                SplitSum::add_dfg_to(&split.dfg, renderer, "dfg")?;
                renderer.uniform("gloss", &[1.0, roughness as f32, 0.0, 0.0])?;
                let shader = split.environment.constants(Shader::new(&["shade_specular"]));
                let reads = vec![
                    ("reflected", Slot::Texture),
                    ("reflected shape", Slot::Uniform),
                    ("gloss", Slot::Uniform),
                    ("dfg", Slot::Texture),
                ];
                Ok(Prepared { shader, reads, is_of_vertices: false, light: LightUse::None })
            }
        }
    }
}

impl Prepared {
    /// Whether the radiance of vertices comes from elsewhere.
    pub(crate) fn is_given(&self) -> bool {
        self.is_of_vertices && matches!(self.light, LightUse::None)
    }

    /// Uploads an expansion of the radiance of the surroundings, in the world frame.
    pub(crate) fn light(&self, renderer: &Renderer, light: &ShVec<Rgb<f64>>) -> Result<(), GpuError> {
        match &self.light {
            LightUse::None => Ok(()),
            LightUse::Radiance(order) => renderer.update("light", &light_vectors(light.coefficients(), *order)),
            LightUse::Irradiance(order) => {
                let irradiance = convolved(light, &Zonal::clamped_cosine(*order));
                renderer.update("light", &light_vectors(irradiance.coefficients(), *order))
            }
            LightUse::Lobe(order, lobe) => renderer.update("light", &lobe_light(light.coefficients(), lobe, *order)),
        }
    }
}

/// Colors as shaders have them.
pub(crate) fn vectors(values: &[Rgb<f32>]) -> Vec<[f32; 4]> {
    values.iter().map(|c| [c.r, c.g, c.b, 1.0]).collect()
}

/// Refuses another number of values than vertices.
pub(crate) fn expect_values(expected: usize, found: usize) -> Result<(), GpuError> {
    if expected == found {
        return Ok(());
    }
    Err(GpuError::Options(format!(
        "expected the radiance of the {expected} vertices of the scene, found {found} values"
    )))
}

fn of_vertices(order: usize) -> Prepared {
    let shader = Shader::new(&["shade_vertices"]);
    Prepared { shader, reads: vec![("radiance", Slot::Read)], is_of_vertices: true, light: LightUse::Radiance(order) }
}

fn expect(what: &str, expected: usize, found: usize) -> Result<(), GpuError> {
    if expected == found {
        return Ok(());
    }
    Err(GpuError::Options(format!("expected transfer of the {expected} {what} of the scene, found {found} receivers")))
}
