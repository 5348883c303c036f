//! A scene in buffers: vertices, triangles, materials and textures.

use bytemuck::{Pod, Zeroable};
use lobe_scene::{Alpha, Mesh, Scene, Texture, TextureUse, Wrap};

use crate::error::GpuError;
use crate::renderer::kernel::Slot;
use crate::renderer::pass::Use;
use crate::renderer::renderer::Renderer;
use crate::scene_view::surface_pieces::{SurfacePiece, SurfacePieces, TEXTURE_STEP, texel_starts, texture_of};

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Vertex {
    pub(crate) position: [f32; 4],
    normal: [f32; 4],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Paint {
    color: [f32; 4],
    place: [f32; 4],
    lightmap: [f32; 4],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct MaterialShape {
    base_color: [f32; 4],
    picture: [u32; 4],
    flags: [u32; 4],
    numbers: [f32; 4],
}

/// Bytes of a place in the buffers `vertices` and `paints`, of a triangle in `corners`, of a mesh in `materials`, of a texel.
pub(crate) const VERTEX: u64 = size_of::<Vertex>() as u64;
pub(crate) const PAINT: u64 = size_of::<Paint>() as u64;
pub(crate) const CORNERS: u64 = size_of::<[u32; 4]>() as u64;
pub(crate) const MATERIAL: u64 = size_of::<MaterialShape>() as u64;
pub(crate) const TEXEL: u64 = size_of::<u32>() as u64;

/// Refuses surfaces that light goes straight through.
///
/// # Errors
/// [`GpuError::Unsupported`].
pub(crate) fn check_scene(scene: &Scene) -> Result<(), GpuError> {
    match scene.materials().iter().find(|m| m.has_holes() && !matches!(m.alpha, Alpha::Mask(_))) {
        None => Ok(()),
        Some(material) => {
            let message = format!(
                "light goes straight through material `{}`, which is not drawn: read the scene without",
                material.name
            );
            Err(GpuError::Unsupported { place: "scene".into(), message })
        }
    }
}

/// Uploads what the module `surface` knows of a scene, besides its vertices; [`surface_reads`] binds it.
///
/// # Errors
/// [`GpuError::Unsupported`] if it does not fit the buffers of the device.
pub(crate) fn add_surfaces(renderer: &mut Renderer, scene: &Scene, surfaces: &SurfacePieces) -> Result<(), GpuError> {
    let paints: Vec<Paint> = (0..scene.meshes().len()).flat_map(|mesh| paints(scene, mesh)).collect();
    renderer.upload("paints", &surfaces.order.placed(paints))?;
    let (starts, end) = texel_starts(scene, 0..scene.textures().len());
    let mut texels = vec![0; end];
    for (texture, start) in scene.textures().iter().zip(&starts) {
        let own = &mut texels[*start as usize..][..texture.texels().len()];
        own.iter_mut().zip(texture.texels()).for_each(|(out, texel)| *out = u32::from_le_bytes(*texel));
    }
    renderer.upload("texels", &texels)?;
    for piece in &surfaces.pieces {
        renderer.upload(&surfaces.name(piece, "corners"), &surfaces.corners[piece.triangles.clone()])?;
        renderer.upload(&surfaces.name(piece, "materials"), &materials(scene, piece, &starts))?;
    }
    Ok(())
}

/// What the module `surface` binds after the camera, in its order.
pub(crate) fn surface_reads(scene: &Scene, surfaces: &SurfacePieces, piece: &SurfacePiece) -> Vec<(Use, Slot)> {
    let (starts, end) = texel_starts(scene, 0..scene.textures().len());
    let start = |texture: usize| TEXEL * starts.get(texture).map_or(end as u64, |start| u64::from(*start));
    let (first, last) = (start(piece.textures.start), start(piece.textures.end));
    // A piece without textures reads no texels, but some have to be bound.
    let last = last.max(first + TEXEL * TEXTURE_STEP as u64);
    let texels = if surfaces.is_whole() { None } else { Some(first..last) };
    let part = |bytes| if surfaces.is_whole() { None } else { Some(piece.places.part(bytes)) };
    [
        Use { name: "vertices".into(), bytes: part(VERTEX) },
        Use { name: surfaces.name(piece, "corners"), bytes: None },
        Use { name: "paints".into(), bytes: part(PAINT) },
        Use { name: surfaces.name(piece, "materials"), bytes: None },
        Use { name: "texels".into(), bytes: texels },
    ]
    .map(|used| (used, Slot::Read))
    .into()
}

/// The vertices of all meshes, mesh by mesh.
pub(crate) fn vertices_of(scene: &Scene) -> Vec<Vertex> {
    let vertex =
        |(p, n): (&[f32; 3], &[f32; 3])| Vertex { position: [p[0], p[1], p[2], 1.0], normal: [n[0], n[1], n[2], 0.0] };
    let of_mesh = |mesh: &Mesh| mesh.positions().iter().zip(mesh.normals()).map(vertex).collect::<Vec<_>>();
    scene.meshes().iter().flat_map(of_mesh).collect()
}

/// What multiplies the base color at the vertices of a mesh, and where those are in pictures.
fn paints(scene: &Scene, mesh: usize) -> Vec<Paint> {
    let (places, mesh) = (places_in_texture(scene, mesh), &scene.meshes()[mesh]);
    let of = |places: &[[f32; 2]], uvs: &[[f32; 2]], i: usize| {
        let [[x, y], [u, v]] = [places, uvs].map(|places| places.get(i).copied().unwrap_or([0.0; 2]));
        [x, y, u, v]
    };
    let paint = |i: usize| Paint {
        color: mesh.colors().get(i).copied().unwrap_or([1.0; 4]),
        place: of(&places, mesh.uvs(0), i),
        lightmap: of(mesh.lightmap_uvs(), mesh.uvs(1), i),
    };
    (0..mesh.positions().len()).map(paint).collect()
}

/// Places are no farther from the picture than this: what is interpolated between them stays finite, and what is so far apart names no
/// texel in single precision anyway.
const FARTHEST: f64 = 1e30;

/// Where the vertices of a mesh are in its texture, by [`TextureUse::map`] in double precision; none without a texture. Where the
/// picture repeats, they count from an even period near the least of them, so that single precision keeps their digits.
fn places_in_texture(scene: &Scene, mesh: usize) -> Vec<[f32; 2]> {
    let Some(used) = texture_of(scene, mesh) else { return Vec::new() };
    let mapped = |uv: &[f32; 2]| TextureUse::map(used.uv_map, *uv);
    let places: Vec<[f64; 2]> = scene.meshes()[mesh].uvs(used.uv_set).iter().map(mapped).collect();
    let wrap = scene.textures()[used.texture].wrap();
    let start: [f64; 2] = std::array::from_fn(|k| match wrap[k] {
        Wrap::Clamp => 0.0,
        Wrap::Repeat | Wrap::Mirror => {
            let least = places.iter().map(|place| place[k]).fold(f64::INFINITY, f64::min);
            2.0 * (0.5 * least).floor()
        }
    });
    let near = |place: &[f64; 2]| [0, 1].map(|k| (place[k] - start[k]).clamp(-FARTHEST, FARTHEST) as f32);
    places.iter().map(near).collect()
}

/// The materials of the meshes of a piece, whose textures begin at these texels of all. A mesh between those of a piece may have no
/// triangle there, and a texture that is before those of the piece: where that begins is then no place, and not read.
fn materials(scene: &Scene, piece: &SurfacePiece, starts: &[u32]) -> Vec<MaterialShape> {
    let first = starts.get(piece.textures.start).copied().unwrap_or(0);
    let shape = |mesh| material_shape(scene, mesh, |texture| starts[texture].wrapping_sub(first));
    piece.meshes.clone().map(shape).collect()
}

fn material_shape(scene: &Scene, mesh: usize, start: impl Fn(usize) -> u32) -> MaterialShape {
    let material = scene.material(mesh);
    let mut shape = MaterialShape { base_color: material.base_color, ..MaterialShape::zeroed() };
    if let Some(used) = texture_of(scene, mesh) {
        let texture = &scene.textures()[used.texture];
        shape.picture = [start(used.texture), texture.width() as u32, texture.height() as u32, wrap_number(texture)];
        shape.flags[0] = 1;
    }
    shape.flags[1] = u32::from(material.double_sided);
    if let Alpha::Mask(cutoff) = material.alpha {
        shape.flags[2] = 1;
        shape.numbers[0] = cutoff;
    }
    shape
}

/// How a texture continues, as shaders have it.
pub(crate) fn wrap_number(texture: &Texture) -> u32 {
    let [u, v] = texture.wrap().map(|wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    });
    u + 3 * v
}

#[cfg(test)]
mod tests {
    use lobe_scene::{Material, MeshParts};

    use super::*;
    use crate::renderer::pieces::Piece;

    /// A triangle with these coordinates, of which the second set is used, and a texture that continues by this way.
    fn triangle(uvs: [[f32; 2]; 3], uv_map: [[f32; 3]; 2], wrap: Wrap) -> Scene {
        let parts = MeshParts {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            uvs: [vec![[0.5; 2]; 3], uvs.to_vec()],
            material: Some(0),
            ..MeshParts::default()
        };
        let used = TextureUse { texture: 0, uv_set: 1, uv_map };
        let material = Material { base_color_texture: Some(used), ..Material::WHITE };
        let texture = Texture::new(4, 4, vec![[255; 4]; 16], [wrap; 2]);
        Scene::new(vec![Mesh::new(parts).unwrap()], vec![material], vec![texture]).unwrap()
    }

    #[test]
    fn places_in_a_texture_are_finite_for_all_coordinates() {
        let most = f32::MAX;
        let uvs = [[most, most], [-most, most], [0.0, -most]];
        for uv_map in [[[most, most, most], [-most, most, 1.0]], [[most, -most, -most], [0.0, 0.0, most]]] {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                let places = places_in_texture(&triangle(uvs, uv_map, wrap), 0);
                // The sum of three of them is finite as well.
                let is_finite = places.iter().flatten().all(|c| (3.0 * c).is_finite());
                assert!(places.len() == 3 && is_finite, "{wrap:?}, {uv_map:?}: {places:?}");
            }
        }
    }

    #[test]
    fn places_far_from_the_first_period_keep_their_digits_and_the_texels_that_they_name() {
        // Exact in single precision; beyond 2^24 single precision has no quarters of a period.
        let (uvs, uv_map) =
            ([[1e6, -2e6], [1e6 + 0.25, -2e6], [1e6, -2e6 + 0.5]], [[64.0, 0.0, 1.25], [0.0, 64.0, 3.5]]);
        let texel = |k: u32| [(k * 16) as u8, (255 - k * 16) as u8, 7, 255];
        let texture = Texture::new(4, 4, (0..16).map(texel).collect(), [Wrap::Mirror; 2]);
        let places = places_in_texture(&triangle(uvs, uv_map, Wrap::Mirror), 0);
        for (place, uv) in places.iter().zip(uvs) {
            let expected = TextureUse::map(uv_map, uv);
            assert!(place.iter().all(|c| (0.0..64.0).contains(c)), "{place:?}, of {expected:?}");
            let [found, expected] = [place.map(f64::from), expected].map(|place| texture.sample(place));
            assert_eq!(found, expected, "the color at {uv:?}");
        }
        // Where a picture ends, its place stays.
        let clamped = places_in_texture(
            &triangle([[-3.0, 0.5], [0.25, 7.0], [0.0; 2]], TextureUse::UV_UNCHANGED, Wrap::Clamp),
            0,
        );
        assert_eq!(clamped, [[-3.0, 0.5], [0.25, 7.0], [0.0; 2]], "clamped");
    }

    #[test]
    fn textures_before_those_of_a_piece_leave_the_places_of_its_own() {
        let triangle = |k: usize| {
            let parts = MeshParts {
                positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, k as f32]],
                triangles: vec![[0, 1, 2]],
                uvs: [vec![[0.0; 2]; 3], Vec::new()],
                material: Some(k),
                ..MeshParts::default()
            };
            Mesh::new(parts).unwrap()
        };
        let material = |k: usize| {
            let used = TextureUse { texture: k, uv_set: 0, uv_map: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };
            Material { base_color_texture: Some(used), ..Material::WHITE }
        };
        let texture = |_| Texture::new(16, 16, vec![[255; 4]; 256], [Wrap::Repeat; 2]);
        let (meshes, textures) = ((0..3).map(triangle).collect(), (0..3).map(texture).collect());
        let scene = Scene::new(meshes, (0..3).map(material).collect(), textures).unwrap();
        let places = Piece { number: 0, items: 0..9 };
        let piece = SurfacePiece { places, triangles: 0..2, meshes: 0..3, textures: 1..3, rows: 0..0 };
        let (starts, _) = texel_starts(&scene, 0..3);
        let found: Vec<u32> = materials(&scene, &piece, &starts).iter().map(|shape| shape.picture[0]).collect();
        assert_eq!(found[1..], [0, 256], "where the textures of the piece begin");
    }
}
