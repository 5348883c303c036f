//! The size of a glTF file with its instances, counted against the limits before anything is made of it.

use std::collections::HashMap;

use gltf_json::mesh::{Mode, Semantic};
use gltf_json::validation::Checked;

use crate::error::SceneError;
use crate::files::gltf::accessor::Accessors;
use crate::files::gltf::files::GltfFile;
use crate::files::gltf::instancing::times_shown;
use crate::files::gltf::nodes::{Origin, walk};
use crate::files::gltf::primitive::{is_of_triangles, place_of};
use crate::files::source::Source;

/// Counts the vertices and triangles of all instances of all meshes shown. Instances are still kept as arrays then.
pub(crate) fn count(file: &GltfFile, source: &mut Source<'_>) -> Result<(), SceneError> {
    let mut of_mesh: HashMap<usize, [usize; 2]> = HashMap::new();
    for shown in walk(&file.root, &Origin::default(), source)?.shown {
        let [vertices, triangles] = match of_mesh.get(&shown.mesh) {
            Some(&size) => size,
            None => {
                let size = size_of(file, shown.mesh, source)?;
                of_mesh.insert(shown.mesh, size);
                size
            }
        };
        let times = times_shown(file, shown.node, source)?;
        source.count(vertices.saturating_mul(times), triangles.saturating_mul(times))?;
    }
    Ok(())
}

/// The vertices and triangles of a mesh. What is missing is found when the mesh is read.
fn size_of(file: &GltfFile, index: usize, source: &Source<'_>) -> Result<[usize; 2], SceneError> {
    let (mut vertices, mut triangles) = (0_usize, 0_usize);
    let Some(mesh) = file.root.meshes.get(index) else { return Ok([0; 2]) };
    for (at, primitive) in mesh.primitives.iter().enumerate() {
        let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
        let (Some(mode), Some(&positions)) = (is_of_triangles(primitive), positions) else { continue };
        let accessors = Accessors { file, place: place_of(mesh, index, at) };
        let points = accessors.count(positions, source)?;
        let corners = match primitive.indices {
            Some(indices) => accessors.count(indices, source)?,
            None => points,
        };
        vertices = vertices.saturating_add(points);
        triangles = triangles.saturating_add(if mode == Mode::Triangles { corners / 3 } else { corners });
    }
    Ok([vertices, triangles])
}
