//! `EXT_mesh_gpu_instancing`: instances kept as arrays, made nodes.

use gltf_json::{Accessor, Index};
use serde_json::{Map, Value, json};

use crate::error::SceneError;
use crate::files::gltf::accessor::Accessors;
use crate::files::gltf::files::{GltfFile, forget_extension, items, push, take_extension};
use crate::files::gltf::nodes::Tree;
use crate::files::source::Source;

const NAME: &str = "EXT_mesh_gpu_instancing";

/// Bytes of a node: its JSON with three arrays, and what is read of it. With one array 1284 were measured; each of the others takes
/// some 300 more by estimate, for its numbers and the object that holds it.
const NODE: u64 = 2048;

/// Bytes of a weight of a morph target: its JSON, and what is read of it.
const WEIGHT: u64 = 64;

/// Gives a node of the scene that shows its mesh many times a child for each: each has transfer of its own. Nodes that are not in the
/// scene stay as they are, since nobody sees theirs.
pub(crate) fn expand(file: &mut GltfFile, source: &mut Source<'_>) -> Result<(), SceneError> {
    let mut was_there = false;
    let mut nodes: Vec<usize> = Tree::of(&file.root, source)?.nodes().collect();
    // Nodes that are added are numbered in the order of the file.
    nodes.sort_unstable();
    for index in nodes {
        let node = &mut file.json["nodes"][index];
        let Some(instancing) = take_extension(node, NAME) else { continue };
        was_there = true;
        let Some(mesh) = node.as_object_mut().and_then(|node| node.remove("mesh")) else { continue };
        let weights = node["weights"].as_array().cloned();
        if node.as_object_mut().and_then(|node| node.remove("skin")).is_some() {
            // Joints carry a skinned mesh, so that all instances would be at one place.
            source.note(format!("node {index} has a skin, but instances of its mesh, which stand as it was bound"));
        }
        let count = count_of(file, index, &instancing["attributes"], source)?;
        let bytes = NODE.saturating_add(WEIGHT.saturating_mul(weights.as_ref().map_or(0, Vec::len) as u64));
        source.count_bytes(bytes.saturating_mul(count as u64))?;
        for mut child in instances(file, index, &instancing["attributes"], source)? {
            child.insert("mesh".to_owned(), mesh.clone());
            child.extend(weights.clone().map(|weights| ("weights".to_owned(), Value::Array(weights))));
            let child = push(&mut file.json, "nodes", Value::Object(child));
            push(&mut file.json["nodes"][index], "children", json!(child));
        }
    }
    if was_there {
        if !items(&mut file.json, "nodes").any(|node| !node["extensions"][NAME].is_null()) {
            forget_extension(&mut file.json, NAME);
        }
        file.update(source)?;
    }
    Ok(())
}

/// How often a node shows its mesh.
pub(crate) fn times_shown(file: &GltfFile, node: usize, source: &Source<'_>) -> Result<usize, SceneError> {
    let instancing = &file.json["nodes"][node]["extensions"][NAME];
    if instancing.is_null() { Ok(1) } else { count_of(file, node, &instancing["attributes"], source) }
}

fn index_of(attributes: &Value, name: &str) -> Option<Index<Accessor>> {
    Some(Index::new(u32::try_from(attributes[name].as_u64()?).ok()?))
}

/// The number of instances.
fn count_of(file: &GltfFile, node: usize, attributes: &Value, source: &Source<'_>) -> Result<usize, SceneError> {
    let accessors = Accessors { file, place: format!("node {node}, {NAME}") };
    let counts = ["TRANSLATION", "ROTATION", "SCALE"].iter().filter_map(|name| index_of(attributes, name));
    let counts: Vec<usize> = counts.map(|index| accessors.count(index, source)).collect::<Result<_, _>>()?;
    let count = counts.first().copied().unwrap_or(0);
    if counts.iter().any(|&other| other != count) {
        return Err(source.invalid(format!("{}: the attributes have {counts:?} elements", accessors.place)));
    }
    source.check_limit(count, count)?;
    Ok(count)
}

/// The transform of each instance, as members of a node.
fn instances(
    file: &GltfFile,
    node: usize,
    attributes: &Value,
    source: &Source<'_>,
) -> Result<Vec<Map<String, Value>>, SceneError> {
    let accessors = Accessors { file, place: format!("node {node}, {NAME}") };
    let mut nodes = vec![Map::new(); count_of(file, node, attributes, source)?];
    let mut put = |name: &str, values: Vec<Value>| {
        nodes.iter_mut().zip(values).for_each(|(node, value)| drop(node.insert(name.to_owned(), value)));
    };
    for (name, member) in [("TRANSLATION", "translation"), ("SCALE", "scale")] {
        if let Some(index) = index_of(attributes, name) {
            put(member, accessors.vectors::<3>(name, index, source)?.into_iter().map(|v| json!(v)).collect());
        }
    }
    if let Some(index) = index_of(attributes, "ROTATION") {
        put("rotation", accessors.vectors::<4>("ROTATION", index, source)?.into_iter().map(|v| json!(v)).collect());
    }
    Ok(nodes)
}
