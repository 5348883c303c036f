//! Primitives of a glTF document with new vertices, each with the attributes of one that there was.

use lobe_scene::GltfDocument;
use serde_json::{Value, json};

use crate::files::baked_glb::push;

const FLOAT: u64 = 5126;
const UNSIGNED_INT: u64 = 5125;
const ARRAY_BUFFER: u64 = 34962;
const ELEMENT_ARRAY_BUFFER: u64 = 34963;

/// The new vertices of a primitive.
pub(crate) struct NewVertices<'a> {
    /// For each the vertex that there was.
    pub(crate) from: &'a [u32],
    /// In the order of the scene, whose triangles run around the other way under a mirror.
    pub(crate) triangles: &'a [[u32; 3]],
    /// Their texture coordinates, and the set that these become.
    pub(crate) uvs: (&'a [[f32; 2]], usize),
}

impl NewVertices<'_> {
    /// Puts them into a primitive of a mesh that one node shows: attributes and morph targets go with them. `None` if
    /// the document stores an attribute in a way that is not followed, such as a sparse one; it is then half changed.
    pub(crate) fn put(&self, document: &mut GltfDocument, [mesh, primitive]: [usize; 2], node: usize) -> Option<()> {
        let place = format!("/meshes/{mesh}/primitives/{primitive}");
        let mut json = document.json.pointer_mut(&place)?.take();
        let mut attributes = json["attributes"].take();
        let targets = json.get_mut("targets").and_then(Value::as_array_mut).into_iter().flatten();
        for accessor in
            targets.chain([&mut attributes]).filter_map(Value::as_object_mut).flat_map(|set| set.values_mut())
        {
            *accessor = json!(taken(document, usize::try_from(accessor.as_u64()?).ok()?, self.from)?);
        }
        let (uvs, set) = self.uvs;
        let bytes: Vec<u8> = uvs.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
        attributes[format!("TEXCOORD_{set}")] = json!(push_array(document, &bytes, (FLOAT, "VEC2", uvs.len())));
        json["attributes"] = attributes;
        let is_mirrored = is_mirrored(&document.json, node);
        let turned = |[a, b, c]: [u32; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
        let corners: Vec<u8> = self.triangles.iter().flat_map(|&t| turned(t)).flat_map(u32::to_le_bytes).collect();
        json["indices"] = json!(push_array(document, &corners, (UNSIGNED_INT, "SCALAR", 3 * self.triangles.len())));
        json["mode"] = json!(4);
        *document.json.pointer_mut(&place)? = json;
        Some(())
    }
}

/// An accessor with some elements of another, in this order.
fn taken(document: &mut GltfDocument, accessor: usize, from: &[u32]) -> Option<usize> {
    let mut copy = document.json["accessors"].get(accessor)?.clone();
    let size = component_bytes(&copy)?.checked_mul(components(&copy)?)?;
    if copy.get("sparse").is_some() {
        return None;
    }
    copy["count"] = json!(from.len());
    let number = |value: &Value, member: &str| value.get(member).map_or(Some(0), Value::as_u64).map(|n| n as usize);
    if let Some(view) = copy.get("bufferView").and_then(Value::as_u64) {
        let view = document.json["bufferViews"].get(view as usize)?;
        let first = number(view, "byteOffset")?.checked_add(number(&copy, "byteOffset")?)?;
        let stride = number(view, "byteStride").filter(|&stride| stride > 0).unwrap_or(size);
        let padded = size.next_multiple_of(4);
        let mut bytes = vec![0; from.len() * padded];
        for (&i, element) in from.iter().zip(bytes.chunks_exact_mut(padded)) {
            let start = first.checked_add((i as usize).checked_mul(stride)?)?;
            element[..size].copy_from_slice(document.bytes.get(start..start.checked_add(size)?)?);
        }
        if copy.get("min").is_some() || copy.get("max").is_some() {
            let [min, max] = bounds(&copy, &bytes, padded)?;
            (copy["min"], copy["max"]) = (min, max);
        }
        let view = push_view(document, &bytes, ARRAY_BUFFER);
        if padded != size {
            document.json["bufferViews"][view]["byteStride"] = json!(padded);
        }
        copy["bufferView"] = json!(view);
        copy.as_object_mut()?.remove("byteOffset");
    }
    Some(push(&mut document.json, "accessors", copy))
}

fn push_array(document: &mut GltfDocument, bytes: &[u8], (component, kind, count): (u64, &str, usize)) -> usize {
    let target = if component == UNSIGNED_INT { ELEMENT_ARRAY_BUFFER } else { ARRAY_BUFFER };
    let view = push_view(document, bytes, target);
    let accessor = json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
    push(&mut document.json, "accessors", accessor)
}

fn push_view(document: &mut GltfDocument, bytes: &[u8], target: u64) -> usize {
    let offset = document.bytes.len().next_multiple_of(4);
    document.bytes.resize(offset, 0);
    document.bytes.extend_from_slice(bytes);
    let view = json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len(), "target": target});
    push(&mut document.json, "bufferViews", view)
}

/// The bytes of a number of an accessor.
fn component_bytes(accessor: &Value) -> Option<usize> {
    match accessor["componentType"].as_u64()? {
        5120 | 5121 => Some(1),
        5122 | 5123 => Some(2),
        UNSIGNED_INT | FLOAT => Some(4),
        _ => None,
    }
}

/// The numbers of an element of an accessor; of attributes no matrices.
fn components(accessor: &Value) -> Option<usize> {
    ["SCALAR", "VEC2", "VEC3", "VEC4"].iter().position(|kind| accessor["type"] == *kind).map(|k| k + 1)
}

/// The smallest and the largest of each number, as they are stored.
fn bounds(accessor: &Value, bytes: &[u8], stride: usize) -> Option<[Value; 2]> {
    let (size, count) = (component_bytes(accessor)?, components(accessor)?);
    let kind = accessor["componentType"].as_u64()?;
    let number = |b: &[u8]| -> Option<f64> {
        Some(match kind {
            5120 => f64::from(b[0] as i8),
            5121 => f64::from(b[0]),
            5122 => f64::from(i16::from_le_bytes(b.try_into().ok()?)),
            5123 => f64::from(u16::from_le_bytes(b.try_into().ok()?)),
            UNSIGNED_INT => f64::from(u32::from_le_bytes(b.try_into().ok()?)),
            _ => f64::from(f32::from_le_bytes(b.try_into().ok()?)),
        })
    };
    let mut found = [vec![f64::MAX; count], vec![f64::MIN; count]];
    for element in bytes.chunks_exact(stride) {
        for (k, b) in element.chunks_exact(size).take(count).enumerate() {
            let number = number(b)?;
            (found[0][k], found[1][k]) = (found[0][k].min(number), found[1][k].max(number));
        }
    }
    Some(found.map(|numbers| json!(numbers)))
}

/// Whether a node stands mirrored in the world: an odd number of nodes down to it mirror.
fn is_mirrored(json: &Value, node: usize) -> bool {
    let nodes = json["nodes"].as_array().map_or(&[][..], Vec::as_slice);
    let has_child = |parent: &Value, child: usize| {
        parent["children"].as_array().into_iter().flatten().any(|c| c.as_u64() == Some(child as u64))
    };
    let (mut current, mut mirrors) = (Some(node), false);
    // No way up is longer than there are nodes.
    for _ in 0..nodes.len() {
        let Some(node) = current else { break };
        mirrors ^= nodes.get(node).is_some_and(mirrors_by_itself);
        current = nodes.iter().position(|parent| has_child(parent, node));
    }
    mirrors
}

fn mirrors_by_itself(node: &Value) -> bool {
    let numbers =
        |member: &str| -> Option<Vec<f64>> { node.get(member)?.as_array()?.iter().map(Value::as_f64).collect() };
    if let Some([a, b, c, _, d, e, f, _, g, h, i, ..]) = numbers("matrix").as_deref() {
        return a * (e * i - f * h) - d * (b * i - c * h) + g * (b * f - c * e) < 0.0;
    }
    numbers("scale").is_some_and(|scale| scale.iter().product::<f64>() < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_go_with_their_vertices_whatever_they_are_stored_as() {
        // Three positions of floats 16 bytes apart, and three colors of three bytes, four apart.
        let positions: Vec<f32> = (0..12).map(|i| i as f32).collect();
        let mut bytes: Vec<u8> = positions.iter().flat_map(|c| c.to_le_bytes()).collect();
        bytes.extend([1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0]);
        let json = json!({
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1}}]}],
            "nodes": [{"children": [1], "scale": [1, -1, 1]}, {"mesh": 0}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 1, 2], "max": [8, 9, 10]},
                {"bufferView": 1, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC3"},
            ],
            "bufferViews": [
                {"buffer": 0, "byteLength": 48, "byteStride": 16},
                {"buffer": 0, "byteOffset": 48, "byteLength": 12, "byteStride": 4},
            ],
        });
        let mut document = GltfDocument { json, bytes };
        let uvs = [[0.0, 0.5], [1.0, 0.5], [0.25, 0.75], [0.0, 0.0]];
        let new = NewVertices { from: &[2, 2, 1, 0], triangles: &[[0, 2, 3]], uvs: (&uvs, 0) };
        new.put(&mut document, [0, 0], 1).unwrap();
        let primitive = &document.json["meshes"][0]["primitives"][0];
        let of = |accessor: &Value| {
            let accessor = &document.json["accessors"][accessor.as_u64().unwrap() as usize];
            let view = &document.json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
            let at = |member: &str| view[member].as_u64().unwrap() as usize;
            (accessor.clone(), document.bytes[at("byteOffset")..][..at("byteLength")].to_vec())
        };
        let (accessor, bytes) = of(&primitive["attributes"]["POSITION"]);
        let floats: Vec<f32> = bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        assert_eq!(floats, [8.0, 9.0, 10.0, 8.0, 9.0, 10.0, 4.0, 5.0, 6.0, 0.0, 1.0, 2.0], "positions");
        assert_eq!((&accessor["count"], &accessor["max"]), (&json!(4), &json!([8.0, 9.0, 10.0])), "{accessor}");
        assert_eq!(of(&primitive["attributes"]["COLOR_0"]).1[..8], [7, 8, 9, 0, 7, 8, 9, 0], "colors");
        assert_eq!(of(&primitive["attributes"]["TEXCOORD_0"]).1.len(), 32, "texture coordinates");
        let corners: Vec<u8> = [0_u32, 3, 2].iter().flat_map(|i| i.to_le_bytes()).collect();
        assert_eq!(of(&primitive["indices"]).1, corners, "turned, as a node mirrors");
        document.json["accessors"][0]["sparse"] = json!({});
        document.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(0);
        assert!(new.put(&mut document, [0, 0], 1).is_none(), "a sparse accessor");
    }
}
