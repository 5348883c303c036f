//! Surfaces of the metallic-roughness model of glTF, what is matte of them by transfer at vertices.

use std::f64::consts::PI;

use lobe_env::LobeFactors;
use lobe_prt::{AlbedoMode, Receivers, Transfer};
use lobe_scene::Scene;

use crate::error::GpuError;
use crate::lookup::specular::SplitSum;
use crate::renderer::kernel::Slot;
use crate::renderer::pass::Use;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::scene_view::finishes::{add_finishes, add_finishes_of_vertices, with_finishes};
use crate::scene_view::suns_apart::SunsApart;
use crate::scene_view::surface_pass::whole;
use crate::scene_view::surface_pieces::{SurfacePiece, SurfacePieces};
use crate::storage::Storage;

/// Bands of the visibility of vertices in shaders.
const ORDER: usize = 3;

/// The uniform of all light and its negative.
pub(crate) const OTHERS_LIGHT: &str = "light of others";

/// Bytes of the visibility of a place: nine numbers, filled up to three vectors.
pub(crate) const VISIBILITY: u64 = size_of::<[[f32; 4]; 3]>() as u64;

/// Surfaces of the metallic-roughness model of glTF 2.0, as `lobe_render::GltfSurfaces` has them.
///
/// ```text
///   B = o (1 - F₀) (1 - metallic) B_matte + (F₀ scale + bias) (o O P(a, roughness) + (1 - O) B_others) + emission
///       + Σ_suns E_sun ((1 - F) (1 - metallic) c/π + F D V)
/// ```
///
/// `B_matte` is by transfer, `P` the prefiltered light, and what is around, `O` and `B_others`, by the part of the
/// transfer without reflections, of which the first three bands count.
#[derive(Clone, Copy, Debug)]
pub struct GltfShading<'a> {
    /// Transfer vectors at vertices.
    pub transfer: &'a Transfer,
    /// Whether they leave out the albedo, [`AlbedoMode::None`].
    pub albedo: AlbedoMode,
    /// Their part without reflections; the same if they have none. Where it is not known, and no
    /// [suns](crate::SunsApart::Reflected) say it, nothing hides reflections.
    pub direct: Option<&'a Transfer>,
    /// What shiny surfaces reflect: the light without the suns that stand apart.
    pub reflections: &'a SplitSum,
    /// How the numbers of transfer are stored.
    pub storage: Storage,
}

impl<'a> GltfShading<'a> {
    /// The same, with a part without reflections that is known elsewhere if there is none.
    pub(crate) fn with_direct(self, direct: Option<&'a Transfer>) -> Self {
        Self { direct: self.direct.or(direct), ..self }
    }

    /// The part without reflections, of transfer that has any.
    pub(crate) fn direct_of_others(&self) -> Option<&'a Transfer> {
        self.direct.filter(|direct| !std::ptr::eq(*direct, self.transfer))
    }

    fn is_without_albedo(&self) -> bool {
        self.albedo == AlbedoMode::None
    }

    /// Uploads all but the transfer itself.
    pub(crate) fn add_to(
        &self,
        renderer: &mut Renderer,
        scene: &Scene,
        surfaces: &SurfacePieces,
    ) -> Result<(), GpuError> {
        self.add_reflections_to(renderer)?;
        add_finishes(renderer, scene, surfaces)?;
        if let Some(direct) = self.direct {
            let visibility = visibility(scene, direct, self.is_without_albedo())?;
            renderer.upload("visibility", &surfaces.order.placed(visibility))?;
        }
        Ok(())
    }

    fn add_reflections_to(&self, renderer: &mut Renderer) -> Result<(), GpuError> {
        self.reflections.add_to(renderer)?;
        renderer.uniform("lobe factors", &lobe_factors(self.transfer.order().min(ORDER)))
    }

    /// Uploads all but the transfer and the colors of vertices, for shaders that read no buffers.
    pub(crate) fn add_vertices_to(
        &self,
        renderer: &mut Renderer,
        scene: &Scene,
        surfaces: &SurfacePieces,
    ) -> Result<(), GpuError> {
        self.add_reflections_to(renderer)?;
        add_finishes_of_vertices(renderer, scene, surfaces)
    }

    /// The shader of vertices, with these suns.
    pub(crate) fn shader_of_vertices(&self, suns: &SunsApart<'_>) -> Shader {
        let order = self.transfer.order();
        let first = if self.direct_of_others().is_some() { order.pow(2) } else { 0 };
        let shader = self.constants(Shader::new(&["draw_gltf_transfer"]));
        let shader = shader.constant("DIRECT", first).constant("KNOWN", order.min(ORDER).pow(2));
        let (shader, sum) = match suns.count() {
            0 => (shader, "vec3f(0.0)"),
            _ => (shader.module("gltf_suns"), "gltf_suns(p, plane, s.n, s.v, s.albedo, s.finish)"),
        };
        let head = "fn sunlight(p: vec3f, plane: vec3f, s: Shiny) -> vec3f {";
        shader.with(&format!("\n{head}\n    return {sum};\n}}\n"))
    }

    /// What the module `draw_gltf_transfer` binds after the transfer and the light.
    pub(crate) fn reads_of_vertices(&self) -> Vec<(Use, Slot)> {
        let others = if self.direct_of_others().is_some() { OTHERS_LIGHT } else { "light" };
        vec![
            (whole(others), Slot::Uniform),
            (whole("reflected"), Slot::Texture),
            (whole("reflected shape"), Slot::Uniform),
            (whole("lobes"), Slot::Texture),
            (whole("lobe factors"), Slot::Uniform),
        ]
    }

    /// A shader with the constants of these surfaces.
    pub(crate) fn constants(&self, shader: Shader) -> Shader {
        let shader = with_finishes(self.reflections.environment.constants(shader));
        shader
            .constant("LOBE_LEVELS", LobeFactors::LEVELS)
            .number("LEAST_ABOVE", LobeFactors::LEAST_ABOVE)
            .number("LEAST_HIDDEN", LobeFactors::LEAST_HIDDEN)
            .constant("WITHOUT_ALBEDO", usize::from(self.is_without_albedo()))
            .constant("HAS_VISIBILITY", usize::from(self.direct.is_some()))
            .constant("HAS_OTHERS", usize::from(self.direct_of_others().is_some()))
    }

    /// What the module `shade_gltf` binds after the surface.
    pub(crate) fn reads(&self, surfaces: &SurfacePieces, piece: &SurfacePiece) -> Vec<(Use, Slot)> {
        let part = |name: &str, bytes: u64| {
            let bytes = if surfaces.is_whole() { None } else { Some(piece.places.part(bytes)) };
            (Use { name: name.into(), bytes }, Slot::Read)
        };
        // Where something is not known, what is bound in its place is not read.
        let known = |name: &'static str, is_known: bool| if is_known { name } else { "radiance" };
        let value = crate::renderer::pieces::VALUE;
        let others = known("others", self.direct_of_others().is_some());
        let visibility = match self.direct {
            Some(_) => part("visibility", VISIBILITY),
            None => part("radiance", value),
        };
        vec![
            part("radiance", value),
            part(others, value),
            visibility,
            (whole("reflected"), Slot::Texture),
            (whole("reflected shape"), Slot::Uniform),
            (whole("lobes"), Slot::Texture),
            (whole(&surfaces.name(piece, "finishes")), Slot::Texture),
            (whole("lobe factors"), Slot::Uniform),
        ]
    }
}

/// What blurs each band by the lobe of GGX, for rising roughness; none of bands that are not known.
fn lobe_factors(order: usize) -> [[f32; 4]; LobeFactors::LEVELS] {
    let factors = LobeFactors::new(order);
    let level = |level: &Vec<f64>| std::array::from_fn(|l| level.get(l).map_or(0.0, |factor| *factor as f32));
    std::array::from_fn(|k| level(&factors.levels()[k]))
}

/// The transfer of visibility of each vertex: that without reflections over the albedo, in the channel that is known
/// best.
fn visibility(scene: &Scene, direct: &Transfer, is_without_albedo: bool) -> Result<Vec<[[f32; 4]; 3]>, GpuError> {
    let receivers = Receivers::at_vertices(scene).map_err(|error| GpuError::Options(error.to_string()))?;
    let last = direct.channels().count() - 1;
    let count = direct.order().min(ORDER).pow(2);
    let of_vertex = |(vertex, albedo): (usize, &[f32; 3])| {
        let best = albedo.iter().copied().fold(0.0, f32::max);
        let (channel, scale) = match is_without_albedo {
            true => (0, 1.0),
            false => (albedo.iter().position(|c| *c >= best).unwrap_or(0), best),
        };
        let row = direct.vector(vertex, channel.min(last));
        let mut numbers = [[0.0; 4]; 3];
        if scale > 0.0 {
            let known = numbers.as_flattened_mut().iter_mut().zip(&row[..count]);
            known.for_each(|(number, coefficient)| *number = coefficient / scale);
        } else {
            // A black surface tells nothing of what is around: open.
            numbers[0][0] = (4.0 * PI).sqrt().recip() as f32;
        }
        numbers
    };
    Ok(receivers.albedos().iter().enumerate().map(of_vertex).collect())
}
