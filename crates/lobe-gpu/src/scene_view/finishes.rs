//! Finishes of materials in a texture: what they say besides a color, for the module `finish`.

use lobe_scene::{Finish, Hit, Material, Scene, TextureUse};

use crate::context::context::Context;
use crate::error::GpuError;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::scene_view::scene_buffers::wrap_number;
use crate::scene_view::surface_pieces::{SurfacePiece, SurfacePieces, TEXTURE_STEP, texel_starts};

/// Texels of a material: two of numbers, and three for each of four textures.
const FINISH: usize = 2 + 3 * 4;

/// Materials side by side in a row of the texture, at most.
const COLUMNS: usize = 64;

/// Buffers of four `f32` for each place.
pub(crate) const FINISHES: &str = "finishes of vertices";
pub(crate) const EMISSIONS: &str = "emissions of vertices";

/// The textures of a finish, in the order of the module: metallic, roughness, occlusion, emission.
fn textures(material: &Material) -> [Option<TextureUse>; 4] {
    let occlusion = material.occlusion_map.map(|map| map.used);
    [material.metallic_texture, material.roughness_texture, occlusion, material.emissive_texture]
}

/// A shader with the constants of the module `finish`.
pub(crate) fn with_finishes(shader: Shader) -> Shader {
    shader.constant("FINISH", FINISH).constant("TEXTURE_STEP", TEXTURE_STEP)
}

/// Uploads a texture `finishes` for each piece.
pub(crate) fn add_finishes(renderer: &mut Renderer, scene: &Scene, surfaces: &SurfacePieces) -> Result<(), GpuError> {
    let (starts, _) = texel_starts(scene, 0..scene.textures().len());
    for piece in &surfaces.pieces {
        let first = starts.get(piece.textures.start).copied().unwrap_or(0);
        let start = |texture: usize| starts[texture].wrapping_sub(first);
        let columns = columns(renderer.context(), piece);
        let rows = piece.meshes.len().div_ceil(columns).max(1);
        let mut texels: Vec<[f32; 4]> = Vec::with_capacity(FINISH * columns * rows);
        piece.meshes.clone().for_each(|mesh| texels.extend(finish(scene, mesh, start)));
        texels.resize(FINISH * columns * rows, [0.0; 4]);
        let size = [(FINISH * columns) as u32, rows as u32];
        let name = surfaces.name(piece, "finishes");
        renderer.upload_texture(&name, size, wgpu::TextureFormat::Rgba32Float, &texels)?;
    }
    Ok(())
}

/// Uploads the finishes of vertices, of which four `f32` are metallic, roughness and occlusion, and their emission.
pub(crate) fn add_finishes_of_vertices(
    renderer: &mut Renderer,
    scene: &Scene,
    surfaces: &SurfacePieces,
) -> Result<(), GpuError> {
    let (mut finishes, mut emissions) = (vec![[0.0; 4]; scene.vertex_count()], vec![[0.0; 4]; scene.vertex_count()]);
    let (mut first, mut triangle) = (0, 0);
    for mesh in scene.meshes() {
        for corners in mesh.triangles() {
            for (corner, [u, v]) in corners.iter().zip([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]) {
                let at = first + *corner as usize;
                let Finish { metallic, roughness, occlusion, emission: [r, g, b] } =
                    scene.finish(&Hit { triangle, t: 0.0, u, v });
                (finishes[at], emissions[at]) = ([metallic, roughness, occlusion, 0.0], [r, g, b, 0.0]);
            }
            triangle += 1;
        }
        first += mesh.positions().len();
    }
    renderer.upload(FINISHES, &surfaces.order.placed(finishes))?;
    renderer.upload(EMISSIONS, &surfaces.order.placed(emissions))
}

fn columns(context: &Context, piece: &SurfacePiece) -> usize {
    let most = context.max_texture_side() as usize / FINISH;
    COLUMNS.min(most).clamp(1, piece.meshes.len().max(1))
}

fn finish(scene: &Scene, mesh: usize, start: impl Fn(usize) -> u32) -> [[f32; 4]; FINISH] {
    let material = scene.material(mesh);
    let mut texels = [[0.0; 4]; FINISH];
    let strength = material.occlusion_map.map_or(0.0, |map| map.strength);
    texels[0] = [material.metallic, material.roughness, strength, 0.0];
    texels[1][..3].copy_from_slice(&material.emissive);
    for (used, texels) in textures(material).into_iter().zip(texels[2..].chunks_exact_mut(3)) {
        // Without coordinates a texture is left out.
        let Some(used) = used.filter(|used| !scene.meshes()[mesh].uvs(used.uv_set).is_empty()) else { continue };
        let texture = &scene.textures()[used.texture];
        // Numbers up to 2^24 are exact: textures begin at multiples of a step.
        let first = start(used.texture) / TEXTURE_STEP as u32;
        let [width, height] = [texture.width(), texture.height()].map(|side| side as f32);
        texels[0] = [first as f32, width, height, wrap_number(texture) as f32];
        for (texel, [x, y, one]) in texels[1..].iter_mut().zip(used.uv_map) {
            *texel = [x, y, one, used.uv_set as f32];
        }
    }
    texels
}
