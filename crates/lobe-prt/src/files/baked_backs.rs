//! The backs of double-sided surfaces in baked glTF files.

use lobe_scene::{GltfReader, Mesh, Scene};

use crate::error::PrtError;
use crate::files::baked_layout::{BACK, attributes_per_channel, read_column};
use crate::transfer::transfer::{Channels, Transfer};

/// The transfer of the backs of some vertices of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedBacks {
    /// The vertices, by their number among all of the scene, in rising order.
    pub vertices: Vec<usize>,
    /// The transfer of the back of each.
    pub transfer: Transfer,
}

/// The vertices of a scene whose backs are seen: those of the meshes whose material is double-sided, in rising order.
/// Their receivers are [`Receivers::backs`](crate::Receivers::backs).
#[must_use]
pub fn double_sided_vertices(scene: &Scene) -> Vec<usize> {
    vertices_where(scene, &|mesh, _| scene.material(mesh).double_sided)
}

/// The vertices of some meshes.
fn vertices_where(scene: &Scene, has: &dyn Fn(usize, &Mesh) -> bool) -> Vec<usize> {
    let (mut vertices, mut first) = (Vec::new(), 0);
    for (number, mesh) in scene.meshes().iter().enumerate() {
        let end = first + mesh.positions().len();
        if has(number, mesh) {
            vertices.extend(first..end);
        }
        first = end;
    }
    vertices
}

/// The backs that a file holds of the meshes of its scene; none if it holds no backs.
pub(crate) fn read_backs(
    scene: &Scene,
    gltf: &GltfReader,
    (order, channels): (usize, Channels),
    name: &str,
) -> Result<Option<BakedBacks>, PrtError> {
    let first = format!("{BACK}0");
    let vertices = vertices_where(scene, &|_, mesh| gltf.has(mesh, &first));
    if vertices.is_empty() {
        return Ok(None);
    }
    let mut coefficients = Vec::new();
    for mesh in scene.meshes().iter().filter(|mesh| gltf.has(mesh, &first)) {
        read_rows(mesh, gltf, BACK, (order, channels), name, &mut coefficients)?;
    }
    let transfer = Transfer::new(order, channels, coefficients).map_err(|error| error.within(name))?;
    Ok(Some(BakedBacks { vertices, transfer }))
}

/// Adds the transfer of the vertices of a mesh, in the attributes of this prefix.
pub(crate) fn read_rows(
    mesh: &Mesh,
    gltf: &GltfReader,
    prefix: &str,
    (order, channels): (usize, Channels),
    name: &str,
    coefficients: &mut Vec<f32>,
) -> Result<(), PrtError> {
    let per_channel = attributes_per_channel(order);
    let columns: Vec<Vec<[f32; 4]>> = (0..channels.count() * per_channel)
        .map(|k| read_column(gltf, mesh, &format!("{prefix}{k}"), name))
        .collect::<Result<_, _>>()?;
    for vertex in 0..mesh.positions().len() {
        for channel in columns.chunks_exact(per_channel) {
            let padded = channel.iter().flat_map(|column| column[vertex]);
            coefficients.extend(padded.take(order * order));
        }
    }
    Ok(())
}
