//! Primitives without normals: glTF asks for flat triangles, which share no vertex where their planes differ.

use gltf_json::Index;
use gltf_json::mesh::{Primitive, Semantic};
use gltf_json::validation::Checked;
use serde_json::{Value, json};

use crate::SceneError;
use crate::files::gltf::accessor::Accessors;
use crate::files::gltf::files::{GltfFile, push};
use crate::files::gltf::primitive::{corners_of, is_of_triangles, place_of, triangles};
use crate::files::source::Source;
use crate::scene::flat::FlatMesh;

/// Gives the triangles of primitives without normals vertices of their own where they need them. The first of those at
/// a point keeps its number; the others stand at the end.
pub(crate) fn split_vertices(file: &mut GltfFile, source: &mut Source<'_>) -> Result<(), SceneError> {
    let mut added = 0;
    for mesh in 0..file.root.meshes.len() {
        for primitive in 0..file.root.meshes[mesh].primitives.len() {
            let flat = {
                let place = place_of(&file.root.meshes[mesh], mesh, primitive);
                flat_mesh(file, &file.root.meshes[mesh].primitives[primitive], place, source)?
            };
            if let Some(flat) = flat.filter(|flat| !flat.added.is_empty()) {
                added += flat.added.len();
                rewrite(file, [mesh, primitive], &flat, source)?;
            }
        }
    }
    if added > 0 {
        source.note(format!(
            "triangles of meshes without normals are flat, as glTF asks, which takes {added} more vertices; \
             --missing-normals smooth makes them round"
        ));
        file.update(source)?;
    }
    Ok(())
}

fn flat_mesh(
    file: &GltfFile,
    primitive: &Primitive,
    place: String,
    source: &Source<'_>,
) -> Result<Option<FlatMesh>, SceneError> {
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let (Some(mode), Some(positions), None) =
        (is_of_triangles(primitive), attribute(Semantic::Positions), attribute(Semantic::Normals))
    else {
        return Ok(None);
    };
    let accessors = Accessors { file, place };
    let corners = corners_of(&accessors, primitive, positions, source)?;
    let positions = accessors.vectors("POSITION", positions, source)?;
    Ok(Some(FlatMesh::new(&positions, &triangles(mode, &corners))))
}

/// Writes the attributes of all vertices and the triangles anew.
fn rewrite(
    file: &mut GltfFile,
    [mesh, primitive]: [usize; 2],
    flat: &FlatMesh,
    source: &Source<'_>,
) -> Result<(), SceneError> {
    let mut json = file.json["meshes"][mesh]["primitives"][primitive].take();
    let mut attributes = json["attributes"].take();
    let targets = json.get_mut("targets").and_then(Value::as_array_mut).into_iter().flatten();
    for accessor in targets.chain([&mut attributes]).filter_map(Value::as_object_mut).flat_map(|set| set.values_mut()) {
        let index = Index::new(accessor.as_u64().and_then(|index| u32::try_from(index).ok()).unwrap_or(u32::MAX));
        let place = place_of(&file.root.meshes[mesh], mesh, primitive);
        let (bytes, size) = Accessors { file, place }.packed(index, source)?;
        let mut all = bytes.clone();
        for &vertex in &flat.added {
            let start = vertex as usize * size;
            // An attribute with fewer elements than there are positions is refused when it is read.
            all.extend_from_slice(bytes.get(start..start + size).unwrap_or_default());
        }
        let mut copy = file.json["accessors"][index.value()].clone();
        copy["count"] = json!(all.len() / size.max(1));
        copy["bufferView"] = json!(file.push_elements(&all, size));
        if let Value::Object(copy) = &mut copy {
            copy.remove("byteOffset");
            copy.remove("sparse");
        }
        *accessor = json!(push(&mut file.json, "accessors", copy));
    }
    json["attributes"] = attributes;
    let indices: Vec<u8> = flat.triangles.as_flattened().iter().flat_map(|i| i.to_le_bytes()).collect();
    let view = file.push_elements(&indices, 4);
    let count = 3 * flat.triangles.len();
    let accessor = json!({"bufferView": view, "componentType": 5125, "count": count, "type": "SCALAR"});
    json["indices"] = json!(push(&mut file.json, "accessors", accessor));
    json["mode"] = json!(4);
    file.json["meshes"][mesh]["primitives"][primitive] = json;
    Ok(())
}
