//! Shading of surfaces: irradiance, transfer, lightmaps, glossy transfer, split sum.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use lobe_env::DfgTable;
use lobe_prt::{CompressedTransfer, GlossyLobe, Lightmap, Transfer, TransferMatrices};
use lobe_scene::Scene;
use lobe_sh::{Expansion as _, Rgb, ShVec, Zonal, convolved};

use crate::lookup::basis::check_order;
use crate::lookup::specular::SplitSum;
use crate::renderer::kernel::Slot;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::scene_view::scene_buffers::SURFACE;
use crate::transfer::gpu_matrices::{add_incident, lobe_light};
use crate::transfer::gpu_transfer::{add_clustered, add_light, add_transfer, light_vectors};
use crate::transfer::texture_transfer::{add_transfer_texture, unshadowed};
use crate::{GpuError, Storage};

/// What lights the surfaces of a scene.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum SurfaceShading<'a> {
    /// Irradiance of normals, without shadows, under light of this order, 1 to 8.
    Irradiance(usize),
    /// Transfer vectors at vertices.
    Vertices(&'a Transfer, Storage),
    /// Transfer vectors at vertices that leave out the albedo, [`AlbedoMode::None`](lobe_prt::AlbedoMode): what they send back is
    /// multiplied by the base color of each pixel.
    Demodulated(&'a Transfer, Storage),
    /// Transfer vectors at vertices, and some meshes that shine instead, by matrices.
    Mixed(&'a Transfer, &'a [GlossyMesh<'a>], Storage),
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

/// A mesh that shines among matte ones.
#[derive(Clone, Copy, Debug)]
pub struct GlossyMesh<'a> {
    /// Its number in the scene.
    pub mesh: usize,
    /// The transfer matrices of its vertices.
    pub matrices: &'a TransferMatrices,
    /// The lobe of its reflection.
    pub lobe: GlossyLobe,
}

/// Triangles that one program draws.
#[derive(Clone, Debug)]
pub(crate) struct SurfacePass {
    pub(crate) name: String,
    pub(crate) shader: Shader,
    /// What it binds after the camera.
    pub(crate) reads: Vec<(String, Slot)>,
    pub(crate) corners: Corners,
}

/// Which corners of triangles are drawn.
#[derive(Clone, Debug)]
pub(crate) enum Corners {
    /// Vertices by the first indices, this many, of the buffer `indices`, with these buffers as attributes.
    Indexed(u32, &'static [&'static str]),
    /// Corners by their numbers among those of all triangles.
    Numbered(Range<u32>),
}

/// What becomes of the light before it is uploaded: each for the uniform of this name.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lights(Vec<(String, LightUse)>);

#[derive(Clone, Debug)]
enum LightUse {
    Radiance(usize),
    Irradiance(usize),
    Lobe(usize, Zonal),
    /// The radiance of vertices comes from elsewhere.
    Given,
}

/// A shading while it is prepared.
struct Prepared<'a> {
    renderer: &'a mut Renderer,
    scene: &'a Scene,
    passes: Vec<SurfacePass>,
    lights: Lights,
}

impl SurfaceShading<'_> {
    /// Adds what has to be done before surfaces are drawn; returns what draws them, and what their light is.
    pub(crate) fn prepare(
        &self,
        renderer: &mut Renderer,
        scene: &Scene,
    ) -> Result<(Vec<SurfacePass>, Lights), GpuError> {
        let mut prepared = Prepared { renderer, scene, passes: Vec::new(), lights: Lights::default() };
        prepared.add(self)?;
        Ok((prepared.passes, prepared.lights))
    }
}

impl Prepared<'_> {
    fn add(&mut self, shading: &SurfaceShading<'_>) -> Result<(), GpuError> {
        let vertices = self.scene.vertex_count();
        match *shading {
            SurfaceShading::Irradiance(order) => self.add_irradiance(order),
            SurfaceShading::Vertices(transfer, storage) => self.add_transfer(transfer, storage, &[]),
            SurfaceShading::Demodulated(transfer, storage) => {
                self.renderer.context().expect_storage("transfer without albedo")?;
                expect("vertices", vertices, transfer.receivers())?;
                self.lights.0.push(("light".into(), LightUse::Radiance(transfer.order())));
                add_transfer(self.renderer, transfer, storage, "radiance")?;
                let (shader, all) = (Shader::new(&["shade_demodulated"]), 0..self.scene.meshes().len());
                self.add_pass("surfaces", shader, &[("radiance", Slot::Read)], all);
                Ok(())
            }
            SurfaceShading::Mixed(transfer, glossy, storage) => {
                let meshes: Vec<usize> = glossy.iter().map(|glossy| glossy.mesh).collect();
                check_meshes(self.scene.meshes().len(), &meshes)?;
                if !meshes.is_empty() {
                    self.renderer.context().expect_storage("meshes that shine")?;
                }
                self.add_transfer(transfer, storage, &meshes)?;
                glossy.iter().try_for_each(|glossy| self.add_glossy_mesh(glossy, storage))
            }
            SurfaceShading::Clusters(transfer) => {
                expect("vertices", vertices, transfer.receivers())?;
                add_clustered(self.renderer, transfer, "radiance")?;
                self.lights.0.push(("light".into(), LightUse::Radiance(transfer.order())));
                self.add_vertices(&[])
            }
            SurfaceShading::Lightmap(transfer, lightmap, storage) => self.add_lightmap(transfer, lightmap, storage),
            SurfaceShading::Glossy(matrices, lobe, storage) => {
                expect("vertices", vertices, matrices.points())?;
                let all = 0..self.scene.meshes().len();
                self.add_glossy("surfaces", (matrices, lobe, storage), 0, all, "")
            }
            SurfaceShading::Radiance(values) => {
                expect_values(vertices, values.len())?;
                self.renderer.upload("radiance", &vectors(values))?;
                self.lights.0.push((String::new(), LightUse::Given));
                self.add_vertices(&[])
            }
            SurfaceShading::Specular(split, roughness) => self.add_specular(split, roughness),
        }
    }

    fn add_irradiance(&mut self, order: usize) -> Result<(), GpuError> {
        check_order(order)?;
        if !self.renderer.context().has_storage() {
            return self.add_transfer(&unshadowed(self.scene, order)?, Storage::F32, &[]);
        }
        add_light(self.renderer, "light")?;
        self.lights.0.push(("light".into(), LightUse::Irradiance(order)));
        let shader = Shader::new(&["shade_irradiance"]).order(order);
        self.add_pass("surfaces", shader, &[("light", Slot::Uniform)], 0..self.scene.meshes().len());
        Ok(())
    }

    fn add_transfer(&mut self, transfer: &Transfer, storage: Storage, without: &[usize]) -> Result<(), GpuError> {
        expect("vertices", self.scene.vertex_count(), transfer.receivers())?;
        self.lights.0.push(("light".into(), LightUse::Radiance(transfer.order())));
        if !self.renderer.context().has_storage() {
            return self.add_texture(transfer, storage);
        }
        add_transfer(self.renderer, transfer, storage, "radiance")?;
        self.add_vertices(without)
    }

    /// Draws vertices by transfer in a texture.
    fn add_texture(&mut self, transfer: &Transfer, storage: Storage) -> Result<(), GpuError> {
        add_transfer_texture(self.renderer, transfer, storage)?;
        let indices = indices(self.scene, &[]);
        self.renderer.upload_indices("indices", &indices)?;
        let shader = Shader::new(&["draw_transfer"]).constant("COEFFICIENTS", transfer.order().pow(2));
        let reads = vec![("transfer".to_owned(), Slot::Texture), ("light".to_owned(), Slot::Uniform)];
        let corners = Corners::Indexed(indices.len() as u32, &["vertices"]);
        self.passes.push(SurfacePass { name: "surfaces".into(), shader, reads, corners });
        Ok(())
    }

    /// Draws the radiance of vertices, without some meshes.
    fn add_vertices(&mut self, without: &[usize]) -> Result<(), GpuError> {
        if !self.scene.has_holes() {
            let indices = indices(self.scene, without);
            self.renderer.upload_indices("indices", &indices)?;
            let (shader, corners) =
                (Shader::new(&["draw_vertices"]), Corners::Indexed(indices.len() as u32, &["vertices", "radiance"]));
            self.passes.push(SurfacePass { name: "surfaces".into(), shader, reads: Vec::new(), corners });
            return Ok(());
        }
        // The meshes between those that are left out.
        let mut first = 0;
        let mut left_out = without.to_vec();
        left_out.sort_unstable();
        left_out.push(self.scene.meshes().len());
        for end in left_out {
            if end > first {
                self.add_pass("surfaces", Shader::new(&["shade_vertices"]), &[("radiance", Slot::Read)], first..end);
            }
            first = end + 1;
        }
        Ok(())
    }

    fn add_lightmap(&mut self, transfer: &Transfer, lightmap: &Lightmap, storage: Storage) -> Result<(), GpuError> {
        expect("texels", lightmap.width().pow(2), transfer.receivers())?;
        add_transfer(self.renderer, transfer, storage, "radiance")?;
        let charts: Vec<u32> =
            lightmap.charts_of_texels().iter().chain(lightmap.charts_of_triangles()).copied().collect();
        self.renderer.upload("charts", &charts)?;
        self.lights.0.push(("light".into(), LightUse::Radiance(transfer.order())));
        let reads = [("radiance", Slot::Read), ("charts", Slot::Read)];
        self.add_pass("surfaces", Shader::new(&["shade_lightmap"]), &reads, 0..self.scene.meshes().len());
        Ok(())
    }

    fn add_glossy_mesh(&mut self, glossy: &GlossyMesh<'_>, storage: Storage) -> Result<(), GpuError> {
        let (GlossyMesh { mesh, matrices, lobe }, meshes) = (*glossy, self.scene.meshes());
        expect("vertices of a mesh", meshes[mesh].positions().len(), matrices.points())?;
        let first: usize = meshes[..mesh].iter().map(|mesh| mesh.positions().len()).sum();
        let of = format!(" of mesh {mesh}");
        self.add_glossy(&format!("glossy mesh {mesh}"), (matrices, lobe, storage), first, mesh..mesh + 1, &of)
    }

    /// Meshes by transfer matrices, those of vertices from `first` on.
    fn add_glossy(
        &mut self,
        name: &str,
        (matrices, lobe, storage): (&TransferMatrices, GlossyLobe, Storage),
        first: usize,
        meshes: Range<usize>,
        of: &str,
    ) -> Result<(), GpuError> {
        add_incident(self.renderer, matrices, storage, of)?;
        let (is_microfacets, roughness) = match lobe {
            GlossyLobe::Phong(_) => (0, 0.0),
            GlossyLobe::Ggx(alpha) => (1, alpha.sqrt() as f32),
        };
        let gloss = GlossShape { is_microfacets, first: first as u32, count: matrices.points() as u32, roughness };
        self.renderer.uniform(&format!("gloss{of}"), &gloss)?;
        if !self.renderer.has("dfg") {
            SplitSum::add_dfg_to(&DfgTable::default(), self.renderer, "dfg")?;
        }
        let order = matrices.order();
        self.lights.0.push((format!("light{of}"), LightUse::Lobe(order, lobe.zonal(order))));
        let (incident, gloss) = (format!("incident{of}"), format!("gloss{of}"));
        let reads = [(incident.as_str(), Slot::Read), (gloss.as_str(), Slot::Uniform), ("dfg", Slot::Texture)];
        self.add_pass(name, Shader::new(&["shade_glossy"]).order(order), &reads, meshes);
        Ok(())
    }

    fn add_specular(&mut self, split: &SplitSum, roughness: f64) -> Result<(), GpuError> {
        split.environment.add_to(self.renderer, "reflected")?;
        SplitSum::add_dfg_to(&split.dfg, self.renderer, "dfg")?;
        self.renderer.uniform("gloss", &[1.0, roughness as f32, 0.0, 0.0])?;
        let shader = split.environment.constants(Shader::new(&["shade_specular"]));
        let reads = [
            ("reflected", Slot::Texture),
            ("reflected shape", Slot::Uniform),
            ("gloss", Slot::Uniform),
            ("dfg", Slot::Texture),
        ];
        self.add_pass("surfaces", shader, &reads, 0..self.scene.meshes().len());
        Ok(())
    }

    /// A pass that draws meshes with a shader that has `shade`, and what that binds after the surface.
    fn add_pass(&mut self, name: &str, shader: Shader, reads: &[(&str, Slot)], meshes: Range<usize>) {
        let surface = SURFACE.into_iter().map(|name| (name, Slot::Read));
        let reads = surface.chain(reads.iter().copied()).map(|(name, slot)| (name.to_owned(), slot)).collect();
        let before = |end: usize| -> usize { self.scene.meshes()[..end].iter().map(|m| m.triangles().len()).sum() };
        let corners = Corners::Numbered(3 * before(meshes.start) as u32..3 * before(meshes.end) as u32);
        self.passes.push(SurfacePass { name: name.into(), shader: shader.module("draw_surface"), reads, corners });
    }
}

/// What a glossy shader knows of its surfaces.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct GlossShape {
    is_microfacets: u32,
    first: u32,
    count: u32,
    roughness: f32,
}

/// The corners of all triangles but those of some meshes, by their numbers among all vertices.
fn indices(scene: &Scene, without: &[usize]) -> Vec<u32> {
    let (mut first, mut indices) = (0, Vec::with_capacity(3 * scene.triangle_count()));
    for (number, mesh) in scene.meshes().iter().enumerate() {
        if !without.contains(&number) {
            indices.extend(mesh.triangles().iter().flatten().map(|i| first + i));
        }
        first += mesh.positions().len() as u32;
    }
    indices
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
                    let irradiance = convolved(light, &Zonal::clamped_cosine(*order));
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

/// Refuses meshes that the scene does not have, and one that is there twice.
fn check_meshes(count: usize, meshes: &[usize]) -> Result<(), GpuError> {
    for (k, mesh) in meshes.iter().enumerate() {
        if *mesh >= count {
            return Err(GpuError::Options(format!("expected one of the {count} meshes, found number {mesh}")));
        }
        if meshes[..k].contains(mesh) {
            return Err(GpuError::Options(format!("expected each mesh once, found number {mesh} twice")));
        }
    }
    Ok(())
}

fn expect(what: &str, expected: usize, found: usize) -> Result<(), GpuError> {
    if expected == found {
        return Ok(());
    }
    Err(GpuError::Options(format!("expected transfer of the {expected} {what} of the scene, found {found} receivers")))
}
