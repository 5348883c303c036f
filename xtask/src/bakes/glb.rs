//! Scenes as .glb files.

use serde_json::{Value, json};

use crate::bakes::shapes::{Part, Shapes};
use crate::bakes::vectors::Vector;

/// The bytes of a .glb file with a node, a mesh and a material for each part.
pub(super) fn glb_of(shapes: &Shapes) -> Vec<u8> {
    let mut file = File::default();
    shapes.parts.iter().for_each(|part| file.add(part));
    let nodes: Vec<usize> = (0..file.meshes.len()).collect();
    let named = |i: usize| json!({"mesh": i, "name": file.meshes[i]["name"]});
    let json = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": nodes}],
        "nodes": nodes.iter().map(|&i| named(i)).collect::<Vec<_>>(),
        "meshes": file.meshes,
        "materials": file.materials,
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{"byteLength": file.bytes.len()}],
    });
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = 28 + text.len() + file.bytes.len();
    let words = |words: &[usize]| words.iter().flat_map(|&word| (word as u32).to_le_bytes()).collect::<Vec<u8>>();
    let chunk = |kind: &[u8; 4], length: usize| [words(&[length]), kind.to_vec()].concat();
    let head = [b"glTF".to_vec(), words(&[2, length]), chunk(b"JSON", text.len()), text].concat();
    [head, chunk(b"BIN\0", file.bytes.len()), file.bytes].concat()
}

#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
}

impl File {
    fn add(&mut self, part: &Part) {
        // glTF has y up.
        let y_up = |v: &Vector| [v[0], v[2], -v[1]].map(|c| c as f32);
        let positions: Vec<[f32; 3]> = part.positions.iter().map(y_up).collect();
        let normals: Vec<[f32; 3]> = part.normals.iter().map(y_up).collect();
        let place = self.push_vectors(&positions);
        let bound = |of: fn(f32, f32) -> f32| {
            (0..3).map(|k| json!(positions.iter().map(|p| p[k]).reduce(of))).collect::<Vec<_>>()
        };
        self.accessors[place]["min"] = json!(bound(f32::min));
        self.accessors[place]["max"] = json!(bound(f32::max));
        let attributes = json!({"POSITION": place, "NORMAL": self.push_vectors(&normals)});
        let indices: Vec<u8> = part.triangles.as_flattened().iter().flat_map(|i| i.to_le_bytes()).collect();
        let indices = self.push(&indices, 34963, json!({"componentType": 5125, "type": "SCALAR"}), indices.len() / 4);
        let [r, g, b] = part.color;
        let matte = json!({"baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0});
        let material = json!({"name": part.name, "pbrMetallicRoughness": matte, "doubleSided": part.double_sided});
        let primitive = json!({"attributes": attributes, "indices": indices, "material": self.materials.len()});
        self.materials.push(material);
        self.meshes.push(json!({"name": part.name, "primitives": [primitive]}));
    }

    fn push_vectors(&mut self, values: &[[f32; 3]]) -> usize {
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
        self.push(&bytes, 34962, json!({"componentType": 5126, "type": "VEC3"}), values.len())
    }

    /// Adds a view and an accessor of numbers of four bytes; returns the index of the accessor.
    fn push(&mut self, bytes: &[u8], target: u32, kind: Value, count: usize) -> usize {
        let (offset, length) = (self.bytes.len(), bytes.len());
        self.views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": length, "target": target}));
        self.bytes.extend_from_slice(bytes);
        let mut accessor = kind;
        accessor["bufferView"] = json!(self.views.len() - 1);
        accessor["count"] = json!(count);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}
