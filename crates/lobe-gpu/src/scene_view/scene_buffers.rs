//! A scene in buffers: vertices, triangles, materials and textures.

use bytemuck::{Pod, Zeroable};
use lobe_scene::{Alpha, Material, Mesh, Scene, Wrap};

use crate::GpuError;
use crate::renderer::renderer::Renderer;

/// The names of the buffers that the module `surface` binds after the camera, in its order.
pub(crate) const SURFACE: [&str; 5] = ["vertices", "corners", "paints", "materials", "texels"];

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Vertex {
    position: [f32; 4],
    normal: [f32; 4],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Paint {
    color: [f32; 4],
    uvs: [f32; 4],
    lightmap: [f32; 4],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct MaterialShape {
    base_color: [f32; 4],
    u_row: [f32; 4],
    v_row: [f32; 4],
    picture: [u32; 4],
    flags: [u32; 4],
    numbers: [f32; 4],
}

/// Uploads what shaders need to know of a scene: the buffers of [`SURFACE`].
///
/// # Errors
/// [`GpuError::Unsupported`] if it does not fit the bindings of the device, or light goes straight through its surfaces.
pub(crate) fn add_scene(renderer: &mut Renderer, scene: &Scene) -> Result<(), GpuError> {
    if let Some(material) = scene.materials().iter().find(|m| m.has_holes() && !matches!(m.alpha, Alpha::Mask(_))) {
        let message = format!(
            "light goes straight through material `{}`, which is not drawn: read the scene without",
            material.name
        );
        return Err(GpuError::Unsupported { place: "scene".into(), message });
    }
    renderer.upload("vertices", &vertices_of(scene))?;
    if !renderer.context().has_storage() {
        // Vertices and indices are all that is drawn by.
        return if scene.has_holes() { renderer.context().expect_storage("surfaces with holes") } else { Ok(()) };
    }
    let (mut first, mut corners, mut paints) = (0, Vec::new(), Vec::new());
    for (number, mesh) in scene.meshes().iter().enumerate() {
        corners.extend(mesh.triangles().iter().map(|[a, b, c]| [first + a, first + b, first + c, number as u32]));
        first += mesh.positions().len() as u32;
        paints.extend((0..mesh.positions().len()).map(|i| paint(mesh, i)));
    }
    let (mut starts, mut texels) = (Vec::new(), Vec::new());
    for texture in scene.textures() {
        starts.push(texels.len() as u32);
        texels.extend(texture.texels().iter().map(|texel| u32::from_le_bytes(*texel)));
    }
    let shape = |(number, mesh)| material_shape(scene, mesh, scene.material(number), &starts);
    let materials: Vec<MaterialShape> = scene.meshes().iter().enumerate().map(shape).collect();
    renderer.upload("corners", &corners)?;
    renderer.upload("paints", &paints)?;
    renderer.upload("materials", &materials)?;
    renderer.upload("texels", &texels)
}

/// The vertices of all meshes, mesh by mesh.
pub(crate) fn vertices_of(scene: &Scene) -> Vec<Vertex> {
    let vertex =
        |(p, n): (&[f32; 3], &[f32; 3])| Vertex { position: [p[0], p[1], p[2], 1.0], normal: [n[0], n[1], n[2], 0.0] };
    let of_mesh = |mesh: &Mesh| mesh.positions().iter().zip(mesh.normals()).map(vertex).collect::<Vec<_>>();
    scene.meshes().iter().flat_map(of_mesh).collect()
}

/// What multiplies the base color at a vertex, and where that is in pictures.
fn paint(mesh: &Mesh, i: usize) -> Paint {
    let uv = |uvs: &[[f32; 2]]| uvs.get(i).copied().unwrap_or([0.0; 2]);
    let ([u0, v0], [u1, v1], [u, v]) = (uv(mesh.uvs(0)), uv(mesh.uvs(1)), uv(mesh.lightmap_uvs()));
    let color = mesh.colors().get(i).copied().unwrap_or([1.0; 4]);
    Paint { color, uvs: [u0, v0, u1, v1], lightmap: [u, v, 0.0, 0.0] }
}

fn material_shape(scene: &Scene, mesh: &Mesh, material: &Material, starts: &[u32]) -> MaterialShape {
    let mut shape = MaterialShape { base_color: material.base_color, ..MaterialShape::zeroed() };
    // Without coordinates a texture is left out.
    let used = material.base_color_texture.filter(|used| !mesh.uvs(used.uv_set).is_empty());
    if let Some(used) = used {
        let texture = &scene.textures()[used.texture];
        let wrap = texture.wrap().map(|wrap| match wrap {
            Wrap::Repeat => 0,
            Wrap::Mirror => 1,
            Wrap::Clamp => 2,
        });
        let [u, v] = used.uv_map;
        shape.u_row[..3].copy_from_slice(&u);
        shape.v_row[..3].copy_from_slice(&v);
        shape.picture = [starts[used.texture], texture.width() as u32, texture.height() as u32, wrap[0] + 3 * wrap[1]];
        shape.flags[0] = 1 + used.uv_set as u32;
    }
    shape.flags[1] = u32::from(material.double_sided);
    if let Alpha::Mask(cutoff) = material.alpha {
        shape.flags[2] = 1;
        shape.numbers[0] = cutoff;
    }
    shape
}
