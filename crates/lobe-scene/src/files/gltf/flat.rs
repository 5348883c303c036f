//! Primitives without normals: glTF asks for flat triangles, which share no vertex where their planes differ.

use std::collections::HashMap;

use gltf_json::mesh::{Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Index};
use serde_json::{Value, json};

use crate::error::SceneError;
use crate::files::gltf::accessor::Accessors;
use crate::files::gltf::files::{GltfFile, push};
use crate::files::gltf::nodes::{Origin, walk};
use crate::files::gltf::primitive::{corners_of, is_of_triangles, place_of, triangles};
use crate::files::source::Source;
use crate::scene::flat::FlatMesh;

/// Gives the triangles of primitives without normals vertices of their own where they need them. The first of those at
/// a point keeps its number; the others stand at the end.
pub(crate) fn split_vertices(file: &mut GltfFile, source: &mut Source<'_>) -> Result<(), SceneError> {
    let mut added = 0;
    for (mesh, times) in times_shown(file, source)?.into_iter().enumerate().filter(|&(_, times)| times > 0) {
        for primitive in 0..file.root.meshes[mesh].primitives.len() {
            let found = without_normals(file, [mesh, primitive], source)?;
            let is_deformed = is_deformed(&file.root.meshes[mesh].primitives[primitive]);
            // Triangles of one plane may lie in several in a pose.
            let flat = found.map(|(positions, triangles)| match is_deformed {
                true => FlatMesh::unshared(positions.len(), &triangles),
                false => FlatMesh::new(&positions, &triangles),
            });
            if let Some(flat) = flat.filter(|flat| !flat.added.is_empty()) {
                added += flat.added.len();
                source.count(flat.added.len().saturating_mul(times), 0)?;
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

/// Whether poses may move vertices of a primitive by themselves.
fn is_deformed(primitive: &Primitive) -> bool {
    let has_joints = primitive.attributes.contains_key(&Checked::Valid(Semantic::Joints(0)));
    has_joints || primitive.targets.iter().flatten().any(|target| target.positions.is_some())
}

/// How often each mesh is shown.
pub(crate) fn times_shown(file: &GltfFile, source: &Source<'_>) -> Result<Vec<usize>, SceneError> {
    let mut times = vec![0; file.root.meshes.len()];
    for shown in walk(&file.root, &Origin::default(), source)?.shown {
        if let Some(times) = times.get_mut(shown.mesh) {
            *times += 1;
        }
    }
    Ok(times)
}

/// Points, and triangles among them.
type Surface = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// The surface of a primitive that has no normals; none of one that has some, or no triangles.
pub(crate) fn without_normals(
    file: &GltfFile,
    [mesh, primitive]: [usize; 2],
    source: &Source<'_>,
) -> Result<Option<Surface>, SceneError> {
    let place = place_of(&file.root.meshes[mesh], mesh, primitive);
    let primitive = &file.root.meshes[mesh].primitives[primitive];
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let (Some(mode), Some(positions), None) =
        (is_of_triangles(primitive), attribute(Semantic::Positions), attribute(Semantic::Normals))
    else {
        return Ok(None);
    };
    let accessors = Accessors { file, place };
    let corners = corners_of(&accessors, primitive, positions, source)?;
    let positions = accessors.vectors("POSITION", positions, source)?;
    Ok(Some((positions, triangles(mode, &corners))))
}

/// The index of an accessor; one that is not there for what is none.
fn index_of(accessor: &Value) -> Index<Accessor> {
    Index::new(accessor.as_u64().and_then(|index| u32::try_from(index).ok()).unwrap_or(u32::MAX))
}

/// Writes the attributes of all vertices and the triangles anew.
fn rewrite(
    file: &mut GltfFile,
    [mesh, primitive]: [usize; 2],
    flat: &FlatMesh,
    source: &mut Source<'_>,
) -> Result<(), SceneError> {
    let mut json = file.json["meshes"][mesh]["primitives"][primitive].take();
    let mut attributes = json["attributes"].take();
    let positions = index_of(&attributes["POSITION"]);
    // What is named many times is copied once.
    let mut copies = HashMap::<usize, usize>::new();
    let targets = json.get_mut("targets").and_then(Value::as_array_mut).into_iter().flatten();
    for accessor in targets.chain([&mut attributes]).filter_map(Value::as_object_mut).flat_map(|set| set.values_mut()) {
        let index = index_of(accessor);
        if let Some(copy) = copies.get(&index.value()) {
            *accessor = json!(copy);
            continue;
        }
        let accessors = Accessors { file, place: place_of(&file.root.meshes[mesh], mesh, primitive) };
        let (count, expected) = (accessors.count(index, source)?, accessors.count(positions, source)?);
        if count != expected {
            let (place, accessor) = (&accessors.place, index.value());
            let message = format!("{place}: expected {expected} elements in accessor {accessor}, found {count}");
            return Err(source.invalid(message));
        }
        let size = accessors.size(index, source)?;
        let room = (count + flat.added.len()) * size;
        source.count_bytes(room as u64)?;
        let mut all = accessors.packed(index, source)?;
        all.reserve_exact(room - all.len());
        for &vertex in &flat.added {
            let start = vertex as usize * size;
            all.extend_from_within(start..start + size);
        }
        let mut copy = file.json["accessors"][index.value()].clone();
        copy["count"] = json!(count + flat.added.len());
        copy["bufferView"] = json!(file.push_elements(&all, size));
        if let Value::Object(copy) = &mut copy {
            copy.remove("byteOffset");
            copy.remove("sparse");
        }
        let copy = push(&mut file.json, "accessors", copy);
        copies.insert(index.value(), copy);
        *accessor = json!(copy);
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
