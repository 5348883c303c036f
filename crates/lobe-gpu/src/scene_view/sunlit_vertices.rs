//! Normals and albedos as attributes of vertices under suns, where shaders read no buffers.

use lobe_prt::Receivers;
use lobe_scene::{Mesh, Scene};

use crate::error::GpuError;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::scene_view::surface_pieces::{SurfacePieces, texture_of};

/// Buffers of four `f32` for each place.
pub(crate) const NORMALS: &str = "normals";
pub(crate) const ALBEDOS: &str = "albedos";

/// Whether the albedo of all pixels is that between vertices, and all surfaces have as many sides, so that vertices
/// by indices show as much as triangles that are looked up.
pub(crate) fn is_plain(scene: &Scene) -> bool {
    let meshes = 0..scene.meshes().len();
    let is_alike = |mesh: usize| scene.material(mesh).double_sided == scene.material(0).double_sided;
    !scene.has_holes() && meshes.into_iter().all(|mesh| texture_of(scene, mesh).is_none() && is_alike(mesh))
}

/// A shader with the fragment of `sunlit_vertices`. Of surfaces with unlike sides all are dark from behind.
pub(crate) fn with_sides(shader: Shader, scene: &Scene) -> Shader {
    let is_double_sided = (0..scene.meshes().len()).all(|mesh| scene.material(mesh).double_sided);
    shader.constant("DOUBLE_SIDED", usize::from(is_double_sided))
}

/// Uploads the normals and the albedos of vertices, which the modules `draw_sunlit_*` fetch.
///
/// # Errors
/// [`GpuError::Options`] if the scene has no vertices.
pub(crate) fn add_sunlit_vertices(
    renderer: &mut Renderer,
    scene: &Scene,
    surfaces: &SurfacePieces,
) -> Result<(), GpuError> {
    let receivers = Receivers::at_vertices(scene).map_err(|error| GpuError::Options(error.to_string()))?;
    let albedos = receivers.albedos().iter().map(|[r, g, b]| [*r, *g, *b, 1.0]).collect();
    renderer.upload(NORMALS, &surfaces.order.placed(normals_of(scene)))?;
    renderer.upload(ALBEDOS, &surfaces.order.placed::<[f32; 4]>(albedos))
}

/// The normals of the vertices of all meshes, mesh by mesh.
pub(crate) fn normals_of(scene: &Scene) -> Vec<[f32; 4]> {
    let normals = scene.meshes().iter().flat_map(Mesh::normals);
    normals.map(|[x, y, z]| [*x, *y, *z, 0.0]).collect()
}
