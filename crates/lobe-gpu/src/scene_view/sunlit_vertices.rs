//! Normals and albedos as attributes of vertices under suns, where shaders read no buffers.

use lobe_prt::Receivers;
use lobe_scene::{Mesh, Scene};

use crate::error::GpuError;
use crate::renderer::renderer::Renderer;
use crate::scene_view::surface_pieces::SurfacePieces;

/// Buffers of four `f32` for each place.
pub(crate) const NORMALS: &str = "normals";
pub(crate) const ALBEDOS: &str = "albedos";

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
