//! `EXT_mesh_gpu_instancing`: instances kept as arrays, made nodes.

use serde_json::{Map, Value, json};

use crate::SceneError;
use crate::files::gltf::accessor::Accessors;
use crate::files::gltf::files::{GltfFile, forget_extension, push, take_extension};
use crate::files::source::Source;

const NAME: &str = "EXT_mesh_gpu_instancing";

/// Gives a node that shows its mesh many times a child for each: each has transfer of its own.
pub(crate) fn expand(file: &mut GltfFile, source: &Source<'_>) -> Result<(), SceneError> {
    let mut was_there = false;
    for index in 0..file.root.nodes.len() {
        let node = &mut file.json["nodes"][index];
        let Some(instancing) = take_extension(node, NAME) else { continue };
        was_there = true;
        let Some(mesh) = node.as_object_mut().and_then(|node| node.remove("mesh")) else { continue };
        for mut child in instances(file, index, &instancing["attributes"], source)? {
            child.insert("mesh".to_owned(), mesh.clone());
            let child = push(&mut file.json, "nodes", Value::Object(child));
            push(&mut file.json["nodes"][index], "children", json!(child));
        }
    }
    if was_there {
        forget_extension(&mut file.json, NAME);
        file.update(source)?;
    }
    Ok(())
}

/// The transform of each instance, as members of a node.
fn instances(
    file: &GltfFile,
    node: usize,
    attributes: &Value,
    source: &Source<'_>,
) -> Result<Vec<Map<String, Value>>, SceneError> {
    let accessors = Accessors { file, place: format!("node {node}, {NAME}") };
    let index_of = |name: &str| Some(gltf_json::Index::new(u32::try_from(attributes[name].as_u64()?).ok()?));
    let counts = ["TRANSLATION", "ROTATION", "SCALE"].iter().filter_map(|name| index_of(name));
    let counts: Vec<usize> = counts.map(|index| accessors.count(index, source)).collect::<Result<_, _>>()?;
    let count = counts.first().copied().unwrap_or(0);
    if counts.iter().any(|&other| other != count) {
        return Err(source.invalid(format!("{}: the attributes have {counts:?} elements", accessors.place)));
    }
    source.check_limit(count, count)?;
    let mut nodes = vec![Map::new(); count];
    let mut put = |name: &str, values: Vec<Value>| {
        nodes.iter_mut().zip(values).for_each(|(node, value)| drop(node.insert(name.to_owned(), value)));
    };
    for (name, member) in [("TRANSLATION", "translation"), ("SCALE", "scale")] {
        if let Some(index) = index_of(name) {
            put(member, accessors.vectors::<3>(name, index, source)?.into_iter().map(|v| json!(v)).collect());
        }
    }
    if let Some(index) = index_of("ROTATION") {
        put("rotation", accessors.vectors::<4>("ROTATION", index, source)?.into_iter().map(|v| json!(v)).collect());
    }
    Ok(nodes)
}
