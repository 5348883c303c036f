//! Builders of small files in memory.

#![allow(dead_code, reason = "each file of tests uses what it needs")]

use serde_json::{Value, json};

/// A glTF file whose one buffer is a `data:` URI or the chunk of a .glb.
pub(crate) struct Gltf {
    pub(crate) json: Value,
    pub(crate) buffer: Vec<u8>,
}

impl Gltf {
    /// One node that shows a square in the plane z = 0 of the y-up file, two triangles of four vertices, indexed.
    pub(crate) fn square() -> Self {
        let positions: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let indices: [u16; 6] = [0, 1, 2, 0, 2, 3];
        let mut buffer: Vec<u8> = positions.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
        buffer.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
        let json = json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"name": "square", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
            ],
            "bufferViews": [
                {"buffer": 0, "byteOffset": 0, "byteLength": 48},
                {"buffer": 0, "byteOffset": 48, "byteLength": 12},
            ],
            "buffers": [{"byteLength": 60}],
        });
        Self { json, buffer }
    }

    /// Changes the JSON at a pointer such as `/nodes/0/mesh`, whose parent has to be there.
    pub(crate) fn with(mut self, pointer: &str, value: Value) -> Self {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match self.json.pointer_mut(parent).unwrap() {
            Value::Array(array) => {
                let index: usize = key.parse().unwrap();
                if index == array.len() { array.push(value) } else { array[index] = value }
            }
            object => object[key] = value,
        }
        self
    }

    /// Adds an attribute of floats to the first primitive.
    pub(crate) fn with_attribute(mut self, name: &str, kind: &str, values: &[f32]) -> Self {
        let (offset, length) = (self.buffer.len(), values.len() * 4);
        self.buffer.extend(values.iter().flat_map(|c| c.to_le_bytes()));
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": length}));
        let view = views.len() - 1;
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(json!({"bufferView": view, "componentType": 5126, "count": 4, "type": kind}));
        let accessor = accessors.len() - 1;
        self.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
        self.json["buffers"][0]["byteLength"] = json!(self.buffer.len());
        self
    }

    /// Adds an accessor of these bytes; returns its index.
    pub(crate) fn push(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let (offset, length) = (self.buffer.len(), bytes.len());
        self.buffer.extend_from_slice(bytes);
        self.json["buffers"][0]["byteLength"] = json!(self.buffer.len());
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": length}));
        let view = views.len() - 1;
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(json!({"bufferView": view, "componentType": component, "count": count, "type": kind}));
        accessors.len() - 1
    }

    /// Adds an accessor of floats; returns its index.
    pub(crate) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let size = match kind {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|c| c.to_le_bytes()).collect();
        self.push(kind, 5126, values.len() / size, &bytes)
    }

    /// Adds a channel with a sampler of its own to the animation of this index, which is made where it is the next.
    pub(crate) fn with_channel(
        mut self,
        animation: usize,
        (node, path): (usize, &str),
        interpolation: &str,
        (times, kind, values): (&[f32], &str, &[f32]),
    ) -> Self {
        let (input, output) = (self.floats("SCALAR", times), self.floats(kind, values));
        let all = &mut self.json["animations"];
        if all.is_null() {
            *all = json!([]);
        }
        let all = all.as_array_mut().unwrap();
        if all.len() == animation {
            all.push(json!({"channels": [], "samplers": []}));
        }
        let samplers = all[animation]["samplers"].as_array_mut().unwrap();
        samplers.push(json!({"input": input, "output": output, "interpolation": interpolation}));
        let sampler = samplers.len() - 1;
        let channels = all[animation]["channels"].as_array_mut().unwrap();
        channels.push(json!({"sampler": sampler, "target": {"node": node, "path": path}}));
        self
    }

    /// The square bound to two joints, nodes 1 and 2, the second above the first by one: the two lower vertices to the first,
    /// the third to the second, the fourth to both by 0.25 and 0.75.
    pub(crate) fn skinned() -> Self {
        let mut file = Self::square().with_attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4));
        let weights = [[1.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.25, 0.75]].map(|[a, b]| [a, b, 0.0, 0.0]);
        let weights = file.floats("VEC4", weights.as_flattened());
        let joints = file.push("VEC4", 5121, 4, &[[0, 1, 0, 0]; 4].concat());
        let mut binds = [[0.0_f32; 16]; 2];
        binds.iter_mut().for_each(|matrix| [0, 5, 10, 15].into_iter().for_each(|k| matrix[k] = 1.0));
        binds[1][13] = -1.0;
        let binds = file.floats("MAT4", binds.as_flattened());
        file.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
        file.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
        file.with("/scenes/0/nodes", json!([0, 1]))
            .with("/nodes/0/skin", json!(0))
            .with("/nodes/1", json!({"name": "hip", "children": [2]}))
            .with("/nodes/2", json!({"name": "knee", "translation": [0.0, 1.0, 0.0]}))
            .with("/skins", json!([{"name": "leg", "joints": [1, 2], "inverseBindMatrices": binds}]))
    }

    /// The same with another node that shows the square where it is.
    pub(crate) fn with_second_square(self) -> Self {
        self.with("/scenes/0/nodes", json!([0, 1])).with("/nodes/1", json!({"mesh": 0}))
    }

    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bin = self.buffer.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let length = 12 + 8 + json.len() + 8 + bin.len();
        let mut bytes = b"glTF".to_vec();
        bytes.extend([2, length as u32].iter().flat_map(|w| w.to_le_bytes()));
        for (chunk, kind) in [(&json, b"JSON"), (&bin, b"BIN\0")] {
            bytes.extend((chunk.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(chunk);
        }
        bytes
    }

    /// The same as JSON, the buffer in a URI.
    pub(crate) fn gltf(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0]["uri"] = json!(format!("data:application/octet-stream;base64,{}", base64(&self.buffer)));
        json.to_string().into_bytes()
    }
}

pub(crate) fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let bits = group.iter().fold(0_u32, |bits, &b| bits << 8 | u32::from(b)) << (8 * (3 - group.len()));
        for k in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * k)) as usize & 63];
            text.push(if k <= group.len() { digit as char } else { '=' });
        }
    }
    text
}
