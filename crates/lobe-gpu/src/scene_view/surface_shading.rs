//! Shading of surfaces: irradiance, transfer, lightmaps, glossy transfer, split sum.

use std::ops::Range;
use std::sync::LazyLock;

use bytemuck::{Pod, Zeroable};
use lobe_env::DfgTable;
use lobe_prt::{CompressedTransfer, GlossyLobe, Lightmap, Transfer, TransferMatrices};
use lobe_scene::Scene;
use lobe_sh::Rgb;

use crate::context::context::Context;
use crate::error::GpuError;
use crate::lookup::basis::check_order;
use crate::lookup::environment::Environment;
use crate::lookup::specular::SplitSum;
use crate::renderer::kernel::Slot;
use crate::renderer::pass::Use;
use crate::renderer::pieces::{VALUE, aligned_items};
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::scene_view::expected::{check_meshes, expect, expect_values, vectors};
use crate::scene_view::finishes::{EMISSIONS, FINISHES};
use crate::scene_view::gltf_shading::{GltfShading, OTHERS_LIGHT, VISIBILITY};
use crate::scene_view::lights::{LightUse, Lights};
use crate::scene_view::scene_buffers::{CORNERS, MATERIAL, PAINT, TEXEL, VERTEX, add_surfaces, surface_reads};
use crate::scene_view::sunlit_vertices::{ALBEDOS, NORMALS, add_sunlit_vertices, is_plain, with_sides};
use crate::scene_view::suns_apart::SunsApart;
use crate::scene_view::surface_pass::{Corners, SurfacePass, whole};
use crate::scene_view::surface_pieces::{Most, SurfacePiece, SurfacePieces};
use crate::storage::Storage;
use crate::transfer::matrix_passes::{add_incident, incident_bytes};
use crate::transfer::reflecting_transfer::ReflectingTransfer;
use crate::transfer::texture_transfer::{add_transfer_texture, unshadowed, vertices_in_texture};
use crate::transfer::vector_passes::{Rows, add_clustered, add_light, add_transfer};

/// The table of what shines among matte meshes: the same for all scenes, computed for the first.
static DFG: LazyLock<DfgTable> = LazyLock::new(DfgTable::default);

/// What lights the surfaces of a scene.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum SurfaceShading<'a> {
    /// Irradiance of normals, without shadows, under light of this order, 1 to 8.
    Irradiance(usize),
    /// Transfer vectors at vertices, and meshes that shine instead, by matrices, if there are any.
    Vertices(&'a Transfer, &'a [GlossyMesh<'a>], Storage),
    /// Transfer vectors at vertices that leave out the albedo, [`AlbedoMode::None`](lobe_prt::AlbedoMode): what they send back is
    /// multiplied by the base color of each pixel.
    Demodulated(&'a Transfer, Storage),
    /// Transfer in clusters, at vertices.
    Clusters(&'a CompressedTransfer),
    /// Transfer vectors at the texels of a lightmap.
    Lightmap(&'a Transfer, &'a Lightmap, Storage),
    /// Transfer matrices at vertices, and the lobe of the reflection.
    Glossy(&'a TransferMatrices, GlossyLobe, Storage),
    /// The radiance of each vertex, computed elsewhere, such as by what moves; [set](crate::SceneView::set_radiance) anew as often as
    /// it changes. The light is not used.
    Radiance(&'a [Rgb<f32>]),
    /// Metals and plastics, by transfer vectors at vertices and the light as shiny surfaces reflect it.
    Gltf(GltfShading<'a>),
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

/// A shading while it is prepared.
struct Prepared<'a> {
    renderer: &'a mut Renderer,
    scene: &'a Scene,
    surfaces: &'a SurfacePieces,
    suns: SunsApart<'a>,
    passes: Vec<SurfacePass>,
    lights: Lights,
}

impl SurfaceShading<'_> {
    /// Adds what has to be done before surfaces are drawn; returns what draws them, and what their light is.
    pub(crate) fn prepare(
        &self,
        renderer: &mut Renderer,
        scene: &Scene,
        surfaces: &SurfacePieces,
        suns: SunsApart<'_>,
    ) -> Result<(Vec<SurfacePass>, Lights), GpuError> {
        self.check_suns(&suns)?;
        if self.binds_surfaces(renderer.context(), scene, &suns) {
            add_surfaces(renderer, scene, surfaces)?;
        }
        let mut prepared = Prepared { renderer, scene, surfaces, suns, passes: Vec::new(), lights: Lights::default() };
        prepared.add(self)?;
        Ok((prepared.passes, prepared.lights))
    }

    /// Refuses suns beside what has all light in an expansion, and transfer without reflections beside what has none
    /// with them.
    fn check_suns(&self, suns: &SunsApart<'_>) -> Result<(), GpuError> {
        let is_fit = match (self, suns) {
            (_, SunsApart::No) => true,
            (Self::Glossy(..) | Self::Specular(..), _) => false,
            (_, SunsApart::Reflected(..)) => {
                matches!(self, Self::Vertices(..) | Self::Demodulated(..) | Self::Lightmap(..) | Self::Gltf(_))
            }
            _ => true,
        };
        if is_fit {
            return Ok(());
        }
        let message = "expected suns in the expansion of this shading, found them apart, with or without reflections";
        Err(GpuError::Options(message.into()))
    }

    /// The environment that is reflected as it is, without an expansion.
    pub(crate) fn reflected(&self) -> Option<&Environment> {
        match self {
            Self::Specular(split, _) => Some(&split.environment),
            Self::Gltf(gltf) => Some(&gltf.reflections.environment),
            _ => None,
        }
    }

    /// Whether shaders look up corners of triangles; else vertices are fetched by indices.
    fn binds_surfaces(&self, context: &Context, scene: &Scene, suns: &SunsApart<'_>) -> bool {
        let is_looked_up = match self {
            Self::Clusters(_) | Self::Radiance(_) => looks_up_vertices(scene, suns),
            Self::Vertices(_, glossy, _) => looks_up_vertices(scene, suns) || !glossy.is_empty(),
            _ => true,
        };
        context.has_storage() && is_looked_up
    }

    /// What a piece of the surfaces has at most on a device.
    pub(crate) fn most(&self, context: &Context, scene: &Scene, suns: &SunsApart<'_>) -> Most {
        if !context.has_storage() {
            let order = match self {
                Self::Irradiance(order) => *order,
                Self::Vertices(transfer, ..) | Self::Gltf(GltfShading { transfer, .. }) => transfer.order(),
                _ => return Most::of_places(usize::MAX),
            };
            let of_others = if let Self::Gltf(gltf) = self { gltf.direct_of_others() } else { None };
            let parts = 1 + usize::from(suns.direct().or(of_others).is_some());
            return Most::of_places(vertices_in_texture(context, parts * order.pow(2)));
        }
        if !self.binds_surfaces(context, scene, suns) {
            return Most::of_places(usize::MAX);
        }
        let fitting = |bytes: u64| (context.max_storage_binding() / bytes) as usize;
        let mut of_place = vec![VERTEX, PAINT, VALUE];
        let (mut alone, mut rows, mut width) = (Vec::new(), usize::MAX, 0);
        match self {
            Self::Glossy(matrices, ..) => of_place.push(incident_bytes(matrices)),
            Self::Gltf(_) => of_place.push(VISIBILITY),
            Self::Vertices(_, glossy, _) => {
                of_place.extend(glossy.iter().map(|glossy| incident_bytes(glossy.matrices)));
                alone.extend(glossy.iter().map(|glossy| glossy.mesh));
            }
            Self::Lightmap(_, lightmap, _) => {
                width = lightmap.width();
                rows = fitting(VALUE * width.max(1) as u64);
            }
            _ => {}
        }
        let (step, largest) = (aligned_items(&of_place), of_place.iter().copied().max().unwrap_or(VALUE));
        let places = fitting(largest) / step * step;
        let (triangles, meshes, texels) = (fitting(CORNERS), fitting(MATERIAL), fitting(TEXEL));
        Most { places, step, triangles, meshes, texels, rows, width, alone }
    }
}

/// Whether what the radiance of vertices shows needs the triangles that are seen.
fn looks_up_vertices(scene: &Scene, suns: &SunsApart<'_>) -> bool {
    scene.has_holes() || suns.count() > 0 && !is_plain(scene)
}

impl Prepared<'_> {
    fn add(&mut self, shading: &SurfaceShading<'_>) -> Result<(), GpuError> {
        let vertices = self.scene.vertex_count();
        match *shading {
            SurfaceShading::Irradiance(order) => self.add_irradiance(order),
            SurfaceShading::Demodulated(transfer, storage) => {
                self.renderer.context().expect_storage("transfer without albedo")?;
                expect("vertices", vertices, transfer.receivers())?;
                self.add_light(transfer);
                self.add_radiance(transfer, storage)?;
                let (shader, all) = (Shader::new(&["shade_demodulated"]), 0..self.scene.meshes().len());
                self.add_passes("surfaces", shader, &all, |pieces, piece| vec![radiance_of(pieces, piece)]);
                Ok(())
            }
            SurfaceShading::Vertices(transfer, glossy, storage) => {
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
                let places = self.surfaces.order.len(transfer.receivers());
                add_clustered(self.renderer, transfer, (places, &|r| self.surfaces.order.vertex(r)), "radiance")?;
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
                self.renderer.upload("radiance", &self.surfaces.order.placed(vectors(values)))?;
                self.lights.0.push((String::new(), LightUse::Given));
                self.add_vertices(&[])
            }
            SurfaceShading::Gltf(gltf) => self.add_gltf(&gltf.with_direct(self.suns.direct())),
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
        let all = 0..self.scene.meshes().len();
        self.add_passes("surfaces", shader, &all, |_, _| vec![(whole("light"), Slot::Uniform)]);
        Ok(())
    }

    /// The light of transfer, with that of suns if its part without reflections is there.
    fn add_light(&mut self, transfer: &Transfer) {
        let order = transfer.order();
        let of = if self.suns.direct().is_some() { LightUse::Reflected(order) } else { LightUse::Radiance(order) };
        self.lights.0.push(("light".into(), of));
    }

    /// The radiance of all places by transfer of their vertices.
    fn add_radiance(&mut self, transfer: &Transfer, storage: Storage) -> Result<(), GpuError> {
        let order = &self.surfaces.order;
        let rows: Rows<'_> = (order.len(transfer.receivers()), &|r| order.vertex(r));
        let transfer = ReflectingTransfer::new(transfer, self.suns.direct())?;
        add_transfer(self.renderer, &transfer, storage, rows, &[("light", "radiance")])
    }

    fn add_gltf(&mut self, gltf: &GltfShading<'_>) -> Result<(), GpuError> {
        expect("vertices", self.scene.vertex_count(), gltf.transfer.receivers())?;
        self.add_light(gltf.transfer);
        let transfer = ReflectingTransfer::new(gltf.transfer, self.suns.direct().or(gltf.direct_of_others()))?;
        let mut lit = vec![("light", "radiance")];
        if gltf.direct_of_others().is_some() {
            lit.push((OTHERS_LIGHT, "others"));
            self.lights.0.push((OTHERS_LIGHT.into(), LightUse::Others(gltf.transfer.order())));
        }
        if !self.renderer.context().has_storage() {
            lit.iter().try_for_each(|(light, _)| add_light(self.renderer, light))?;
            gltf.add_vertices_to(self.renderer, self.scene, self.surfaces)?;
            add_sunlit_vertices(self.renderer, self.scene, self.surfaces)?;
            let program = (gltf.shader_of_vertices(&self.suns), gltf.reads_of_vertices());
            let attributes = &["vertices", NORMALS, ALBEDOS, FINISHES, EMISSIONS];
            return self.add_texture_by((&transfer, gltf.storage), program, attributes);
        }
        let order = &self.surfaces.order;
        let rows: Rows<'_> = (order.len(gltf.transfer.receivers()), &|r| order.vertex(r));
        add_transfer(self.renderer, &transfer, gltf.storage, rows, &lit)?;
        gltf.add_to(self.renderer, self.scene, self.surfaces)?;
        let (shader, all) = (gltf.constants(Shader::new(&["shade_gltf"])), 0..self.scene.meshes().len());
        let lit = Lit { shader, suns: self.suns, sunlight: "sunlit_gltf" };
        self.add_passes_in("surfaces", lit, &all, |pieces, piece| gltf.reads(pieces, piece));
        Ok(())
    }

    fn add_transfer(&mut self, transfer: &Transfer, storage: Storage, without: &[usize]) -> Result<(), GpuError> {
        expect("vertices", self.scene.vertex_count(), transfer.receivers())?;
        self.add_light(transfer);
        if !self.renderer.context().has_storage() {
            return self.add_texture(transfer, storage);
        }
        self.add_radiance(transfer, storage)?;
        self.add_vertices(without)
    }

    /// Draws vertices by transfer in textures.
    fn add_texture(&mut self, transfer: &Transfer, storage: Storage) -> Result<(), GpuError> {
        let transfer = ReflectingTransfer::new(transfer, self.suns.direct())?;
        let (module, attributes): (_, &'static [&'static str]) = if self.suns.count() > 0 {
            add_sunlit_vertices(self.renderer, self.scene, self.surfaces)?;
            ("draw_sunlit_transfer", &["vertices", NORMALS, ALBEDOS])
        } else {
            ("draw_transfer", &["vertices"])
        };
        self.add_texture_by((&transfer, storage), (Shader::new(&[module]), Vec::new()), attributes)
    }

    /// The same by a shader, and what it binds after the transfer and the light.
    fn add_texture_by(
        &mut self,
        (transfer, storage): (&ReflectingTransfer<'_>, Storage),
        (shader, more): (Shader, Vec<(Use, Slot)>),
        attributes: &'static [&'static str],
    ) -> Result<(), GpuError> {
        let ranges = self.upload_indices(&[])?;
        let shader = with_sides(shader, self.scene).constant("COEFFICIENTS", transfer.coefficients());
        for (piece, range) in self.surfaces.pieces.iter().zip(ranges) {
            let name = self.surfaces.name(piece, "transfer");
            let places = piece.places.items.clone();
            let of: &dyn Fn(usize) -> usize = &|place| self.surfaces.order.vertex(place);
            add_transfer_texture(self.renderer, transfer, storage, (places.clone(), of), &name)?;
            self.renderer.uniform(&format!("{name} shape"), &[places.start as u32, 0, 0, 0])?;
            let shape = whole(&format!("{name} shape"));
            let mut reads =
                vec![(whole(&name), Slot::Texture), (whole("light"), Slot::Uniform), (shape, Slot::Uniform)];
            reads.extend(more.iter().cloned());
            let shader = self.suns.added_to(shader.clone(), &mut reads);
            let name = self.surfaces.name(piece, "surfaces");
            let corners = Corners::Indexed(range, "indices", attributes);
            self.passes.push(SurfacePass { name, shader, reads, corners });
        }
        Ok(())
    }

    /// Uploads the places of the corners of all triangles but those of some meshes, as `indices`; returns those of each piece.
    fn upload_indices(&mut self, without: &[usize]) -> Result<Vec<Range<u32>>, GpuError> {
        let (mut indices, mut ranges) = (Vec::with_capacity(3 * self.scene.triangle_count()), Vec::new());
        for piece in &self.surfaces.pieces {
            let (begin, first) = (indices.len() as u32, piece.places.items.start as u32);
            for [a, b, c, mesh] in &self.surfaces.corners[piece.triangles.clone()] {
                if !without.contains(&(piece.meshes.start + *mesh as usize)) {
                    indices.extend([first + a, first + b, first + c]);
                }
            }
            ranges.push(begin..indices.len() as u32);
        }
        self.renderer.upload_indices("indices", &indices)?;
        Ok(ranges)
    }

    /// Draws the radiance of vertices, without some meshes.
    fn add_vertices(&mut self, without: &[usize]) -> Result<(), GpuError> {
        let has_suns = self.suns.count() > 0;
        if !self.renderer.context().has_storage() || !looks_up_vertices(self.scene, &self.suns) {
            // Fetched and not bound, all pieces are drawn at once.
            let end = self.upload_indices(without)?.last().map_or(0, |range| range.end);
            let (module, attributes): (_, &'static [&'static str]) = if has_suns {
                add_sunlit_vertices(self.renderer, self.scene, self.surfaces)?;
                ("draw_sunlit_vertices", &["vertices", "radiance", NORMALS, ALBEDOS])
            } else {
                ("draw_vertices", &["vertices", "radiance"])
            };
            let mut reads = Vec::new();
            let shader = self.suns.added_to(with_sides(Shader::new(&[module]), self.scene), &mut reads);
            let corners = Corners::Indexed(0..end, "indices", attributes);
            self.passes.push(SurfacePass { name: "surfaces".into(), shader, reads, corners });
            return Ok(());
        }
        // The meshes between those that are left out.
        let mut first = 0;
        let mut left_out = without.to_vec();
        left_out.sort_unstable();
        left_out.push(self.scene.meshes().len());
        let shader = Shader::new(&["shade_vertices"]);
        for end in left_out {
            if end > first {
                let some = first..end;
                self.add_passes("surfaces", shader.clone(), &some, |pieces, piece| vec![radiance_of(pieces, piece)]);
            }
            first = end + 1;
        }
        Ok(())
    }

    fn add_lightmap(&mut self, transfer: &Transfer, lightmap: &Lightmap, storage: Storage) -> Result<(), GpuError> {
        let width = lightmap.width();
        expect("texels", width.pow(2), transfer.receivers())?;
        let all = ReflectingTransfer::new(transfer, self.suns.direct())?;
        add_transfer(self.renderer, &all, storage, (all.receivers(), &|r| r), &[("light", "radiance")])?;
        self.renderer.upload("charts of texels", lightmap.charts_of_texels())?;
        let charts = lightmap.charts_of_triangles();
        for piece in &self.surfaces.pieces {
            let numbers = &self.surfaces.numbers[piece.triangles.clone()];
            let own: Vec<u32> = numbers.iter().map(|number| charts[*number as usize]).collect();
            self.renderer.upload(&self.surfaces.name(piece, "charts of triangles"), &own)?;
            let shape = [width as u32, piece.rows.start as u32, 0, 0];
            self.renderer.uniform(&self.surfaces.name(piece, "lightmap"), &shape)?;
        }
        self.add_light(transfer);
        let all = 0..self.scene.meshes().len();
        self.add_passes("surfaces", Shader::new(&["shade_lightmap"]), &all, |pieces, piece| {
            let rows = |name: &str, bytes: u64| {
                let row = bytes * width as u64;
                Use { name: name.into(), bytes: Some(piece.rows.start as u64 * row..piece.rows.end as u64 * row) }
            };
            let (radiance, charts) = (rows("radiance", VALUE), rows("charts of texels", CHART));
            let read = |used: Use| (if pieces.is_whole() { whole(&used.name) } else { used }, Slot::Read);
            let own = whole(&pieces.name(piece, "charts of triangles"));
            let shape = whole(&pieces.name(piece, "lightmap"));
            vec![read(radiance), read(charts), (own, Slot::Read), (shape, Slot::Uniform)]
        });
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
        let own = |piece: &&SurfacePiece| piece.meshes.start < meshes.end && meshes.start < piece.meshes.end;
        let of_meshes: Vec<&SurfacePiece> = self.surfaces.pieces.iter().filter(own).collect();
        // In pieces, those of these meshes have no others.
        let places = match (&of_meshes[..], self.surfaces.is_whole()) {
            ([begin, .., end], false) => begin.places.items.start..end.places.items.end,
            ([one], false) => one.places.items.clone(),
            _ => first..first + matrices.points(),
        };
        let order = &self.surfaces.order;
        // Places that fill a piece up have a vertex of any mesh.
        let points: Rows<'_> = (places.len(), &|r| order.vertex(places.start + r).saturating_sub(first));
        add_incident(self.renderer, matrices, storage, points, of)?;
        let (first, begin) = if self.surfaces.is_whole() { (first, 0) } else { (0, places.start) };
        let (is_microfacets, roughness) = match lobe {
            GlossyLobe::Phong(_) => (0, 0.0),
            GlossyLobe::Ggx(alpha) => (1, alpha.sqrt() as f32),
        };
        let gloss = GlossShape { is_microfacets, first: first as u32, roughness, unused: 0 };
        self.renderer.uniform(&format!("gloss{of}"), &gloss)?;
        if !self.renderer.has("dfg") {
            SplitSum::add_dfg_to(&DFG, self.renderer, "dfg")?;
        }
        let order = matrices.order();
        self.lights.0.push((format!("light{of}"), LightUse::Lobe(order, lobe.zonal(order))));
        let vector = incident_bytes(matrices);
        let shader = Shader::new(&["shade_glossy"]).order(order);
        let lit = Lit { shader, suns: SunsApart::No, sunlight: MATTE };
        self.add_passes_in(name, lit, &meshes, |pieces, piece| {
            let places = piece.places.items.start - begin..piece.places.items.end - begin;
            let part = vector * places.start as u64..vector * places.end as u64;
            let bytes = if pieces.is_whole() { None } else { Some(part) };
            let incident = Use { name: format!("incident{of}"), bytes };
            let gloss = whole(&format!("gloss{of}"));
            vec![(incident, Slot::Read), (gloss, Slot::Uniform), (whole("dfg"), Slot::Texture)]
        });
        Ok(())
    }

    fn add_specular(&mut self, split: &SplitSum, roughness: f64) -> Result<(), GpuError> {
        split.add_to(self.renderer)?;
        self.renderer.uniform("gloss", &[1.0, roughness as f32, 0.0, 0.0])?;
        let shader = split.environment.constants(Shader::new(&["shade_specular"]));
        let reads = [
            ("reflected", Slot::Texture),
            ("reflected shape", Slot::Uniform),
            ("gloss", Slot::Uniform),
            ("lobes", Slot::Texture),
        ];
        let all = 0..self.scene.meshes().len();
        self.add_passes("surfaces", shader, &all, |_, _| reads.map(|(name, slot)| (whole(name), slot)).into());
        Ok(())
    }

    /// Passes that draw meshes, piece by piece, with a shader that has `shade`, and what that binds after the surface.
    fn add_passes(
        &mut self,
        name: &str,
        shader: Shader,
        meshes: &Range<usize>,
        reads: impl Fn(&SurfacePieces, &SurfacePiece) -> Vec<(Use, Slot)>,
    ) {
        self.add_passes_in(name, Lit { shader, suns: self.suns, sunlight: MATTE }, meshes, reads);
    }

    /// The same with these suns apart.
    fn add_passes_in(
        &mut self,
        name: &str,
        Lit { shader, suns, sunlight }: Lit<'_>,
        meshes: &Range<usize>,
        reads: impl Fn(&SurfacePieces, &SurfacePiece) -> Vec<(Use, Slot)>,
    ) {
        let has_suns = suns.count() > 0;
        let shader = if has_suns { shader.module(sunlight) } else { shader };
        let sum = if has_suns { "shade(s) + sunlight(s)" } else { "shade(s)" };
        let lit = format!("\nfn lit(s: Surface) -> vec3f {{\n    return {sum};\n}}\n");
        let shader = shader.module("draw_surface").with(&lit);
        for piece in &self.surfaces.pieces {
            let triangles = self.surfaces.of_meshes(piece, meshes);
            if triangles.is_empty() && !self.surfaces.is_whole() {
                continue;
            }
            let mut bound = surface_reads(self.scene, self.surfaces, piece);
            bound.extend(reads(self.surfaces, piece));
            let (name, shader) = (self.surfaces.name(piece, name), suns.added_to(shader.clone(), &mut bound));
            let corners = Corners::Numbered(3 * triangles.start..3 * triangles.end);
            self.passes.push(SurfacePass { name, shader, reads: bound, corners });
        }
    }
}

/// A shader that has `shade`, suns beside it, and the module that has `sunlight`.
struct Lit<'a> {
    shader: Shader,
    suns: SunsApart<'a>,
    sunlight: &'static str,
}

/// The module with the light of suns on matte surfaces.
const MATTE: &str = "sunlit_matte";

/// The radiance of the places of a piece.
fn radiance_of(surfaces: &SurfacePieces, piece: &SurfacePiece) -> (Use, Slot) {
    let bytes = if surfaces.is_whole() { None } else { Some(piece.places.values()) };
    (Use { name: "radiance".into(), bytes }, Slot::Read)
}

/// Bytes of the chart of a texel.
const CHART: u64 = size_of::<u32>() as u64;

/// What a glossy shader knows of its surfaces.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct GlossShape {
    is_microfacets: u32,
    first: u32,
    roughness: f32,
    unused: u32,
}
