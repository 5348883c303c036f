//! glTF document with the vertices of a split scene: everything else in it stays.

use std::collections::HashMap;

use gltf_json::accessor::ComponentType;
use gltf_json::mesh::Semantic;
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Index};
use serde_json::{Map, Value, json};

use crate::error::SceneError;
use crate::files::gltf::accessor::Accessors;
use crate::files::gltf::document::GltfDocument;
use crate::files::gltf::files::{GltfFile, push};
use crate::files::gltf::middles::{Influences, Middle, append_influences};
use crate::files::gltf::orientation::is_turned;
use crate::files::gltf::primitive::{corners_of, is_of_triangles, place_of, triangles};
use crate::files::gltf::root::Root;
use crate::files::read_options::SceneReadOptions;
use crate::files::source::Source;
use crate::scene::mesh::Mesh;

const FLOAT: u32 = 5126;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Vertices that indices of two bytes can name; 65535 restarts a primitive.
const SHORT_INDICES: usize = 65535;

impl GltfDocument {
    /// The document with the further vertices of meshes that were split. Each mesh comes with the indices of the mesh
    /// and of the primitive that it was read from; [`Mesh::halved`] says between which vertices the new ones lie.
    ///
    /// ```text
    ///   POSITION, TEXCOORD_n, COLOR_n, morph targets:  a_m = (a_p + a_q) / 2 in the middle of the edge from p to q
    ///   NORMAL, TANGENT:  the direction of that, with the handedness of p
    ///   JOINTS_n, WEIGHTS_n:  those of both ends, weights halved; of too many the heaviest, scaled to the whole weight
    ///   _NAME:  as COLOR_n, but that of p where it is a whole number or a name (_FEATURE_ID_n, _BATCHID)
    /// ```
    ///
    /// New accessors hold the attributes of all vertices and the triangles. The old ones stay, which others may use;
    /// [`GltfDocument::pruned`] takes out those that nobody does. Whole
    /// numbers become floats where rounding would move something: positions, directions, weights, and coordinates that
    /// are no fractions. Sparse accessors become dense ones. Where a node mirrors its mesh, triangles keep the
    /// orientation that they have in the file.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] if a mesh is not of its primitive, or numbers of it are not in the document.
    pub fn subdivided(self, split: &[([usize; 2], &Mesh)]) -> Result<Self, SceneError> {
        if split.is_empty() {
            return Ok(self);
        }
        let source = Source::new("the document", None, &SceneReadOptions::default());
        let root = Root::of(&self.json, &source)?;
        let buffers = if root.buffers.is_empty() { Vec::new() } else { vec![self.bytes] };
        let mut file = GltfFile { json: self.json, root, buffers };
        for &(place, mesh) in split {
            rewrite(&mut file, place, mesh, &source)?;
        }
        Self::of_file(file, &source)
    }
}

/// Writes the attributes of all vertices and the triangles of a primitive anew.
fn rewrite(
    file: &mut GltfFile,
    [mesh, primitive]: [usize; 2],
    split: &Mesh,
    source: &Source<'_>,
) -> Result<(), SceneError> {
    let turned = turned(file, [mesh, primitive], split, source)?;
    let mut json = file.json["meshes"][mesh]["primitives"][primitive].take();
    let mut writer = Writer { file, place: [mesh, primitive], split, source, copies: HashMap::new() };
    if let Some(attributes) = json["attributes"].as_object_mut() {
        let is_skinned = writer.write_influences(attributes)?;
        for (name, accessor) in attributes {
            if !(is_skinned && (name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_"))) {
                *accessor = json!(writer.write(name, index_of(accessor), Middle::of)?);
            }
        }
    }
    for target in json.get_mut("targets").and_then(Value::as_array_mut).into_iter().flatten() {
        for (name, accessor) in target.as_object_mut().into_iter().flatten() {
            // Differences of directions are no directions.
            *accessor = json!(writer.write(name, index_of(accessor), |_, _| Middle::Mean)?);
        }
    }
    json["indices"] = json!(writer.write_triangles(turned));
    json["mode"] = json!(4);
    file.json["meshes"][mesh]["primitives"][primitive] = json;
    Ok(())
}

/// Whether the triangles of a mesh run around the other way in its primitive.
fn turned(
    file: &GltfFile,
    [mesh, primitive]: [usize; 2],
    split: &Mesh,
    source: &Source<'_>,
) -> Result<bool, SceneError> {
    let found = file.root.meshes.get(mesh).and_then(|of| Some((of, of.primitives.get(primitive)?)));
    let Some((json, found)) = found else {
        return Err(source.invalid(format!("mesh {mesh} has no primitive {primitive}")));
    };
    let accessors = Accessors { file, place: place_of(json, mesh, primitive) };
    let foreign = || {
        let message = "expected a mesh of this primitive whose edges were halved, found another";
        source.invalid(format!("{}: {message}", accessors.place))
    };
    let positions = found.attributes.get(&Checked::Valid(Semantic::Positions)).copied();
    let (Some(mode), Some(positions)) = (is_of_triangles(found), positions) else { return Err(foreign()) };
    let own = split.positions().len() - split.halved().len();
    if accessors.count(positions, source)? != own {
        return Err(foreign());
    }
    let corners = corners_of(&accessors, found, positions, source)?;
    is_turned(&triangles(mode, &corners), split).ok_or_else(foreign)
}

/// The index of an accessor; one that is not there for what is none.
fn index_of(accessor: &Value) -> Index<Accessor> {
    Index::new(accessor.as_u64().and_then(|index| u32::try_from(index).ok()).unwrap_or(u32::MAX))
}

/// A primitive that is written anew.
struct Writer<'a, 'b> {
    file: &'a mut GltfFile,
    place: [usize; 2],
    split: &'a Mesh,
    source: &'a Source<'b>,
    /// What is named many times is written once.
    copies: HashMap<(usize, Middle, bool), usize>,
}

impl Writer<'_, '_> {
    fn accessors(&self) -> Accessors<'_> {
        let [mesh, primitive] = self.place;
        Accessors { file: self.file, place: place_of(&self.file.root.meshes[mesh], mesh, primitive) }
    }

    /// Refuses an attribute with another number of elements than the mesh had vertices.
    fn check_count(&self, index: Index<Accessor>) -> Result<(), SceneError> {
        let expected = self.split.positions().len() - self.split.halved().len();
        let accessors = self.accessors();
        match accessors.count(index, self.source)? {
            found if found == expected => Ok(()),
            found => {
                let (place, accessor) = (&accessors.place, index.value());
                let message = format!("{place}: expected {expected} elements in accessor {accessor}, found {found}");
                Err(self.source.invalid(message))
            }
        }
    }

    /// Writes an attribute of all vertices; returns its accessor.
    fn write(
        &mut self,
        name: &str,
        index: Index<Accessor>,
        middle: impl Fn(&str, bool) -> Middle,
    ) -> Result<usize, SceneError> {
        self.check_count(index)?;
        let old = &self.file.root.accessors[index.value()];
        let Checked::Valid(component) = old.component_type else {
            return Err(self.source.invalid(format!("accessor {} is of no type that glTF knows", index.value())));
        };
        let is_counted = component.0 != ComponentType::F32 && !old.normalized;
        let stays_whole = !is_counted && ["TEXCOORD", "COLOR", "_"].iter().any(|known| name.starts_with(known));
        let (rule, bounds) = (middle(name, is_counted), name == "POSITION");
        if let Some(&copy) = self.copies.get(&(index.value(), rule, bounds)) {
            return Ok(copy);
        }
        let written = if rule == Middle::First {
            self.write_first(index)?
        } else {
            let (mut values, size) = self.accessors().floats(index, self.source)?;
            rule.append(&mut values, size, self.split.halved());
            let kind = if stays_whole { component.0 } else { ComponentType::F32 };
            let mut bytes = Vec::with_capacity(values.len() * kind.size());
            values.iter().for_each(|&value| push_encoded(&mut bytes, value, kind));
            let accessor = self.push_attribute(index, &bytes, size * kind.size());
            if kind == ComponentType::F32 {
                self.declare_float(accessor, bounds.then_some((&values, size)));
            }
            accessor
        };
        self.copies.insert((index.value(), rule, bounds), written);
        Ok(written)
    }

    /// Copies the bytes of the first end of each edge.
    fn write_first(&mut self, index: Index<Accessor>) -> Result<usize, SceneError> {
        let (size, mut bytes) =
            (self.accessors().size(index, self.source)?, self.accessors().packed(index, self.source)?);
        for &[first, _] in self.split.halved() {
            let start = first as usize * size;
            bytes.extend_from_within(start..start + size);
        }
        Ok(self.push_attribute(index, &bytes, size))
    }

    /// Writes joints and weights together, if there are as many sets of both; whether there are.
    fn write_influences(&mut self, attributes: &mut Map<String, Value>) -> Result<bool, SceneError> {
        let count = |kind: &str| attributes.keys().filter(|name| name.starts_with(kind)).count();
        let sets = count("JOINTS_");
        let is_there = |set| ["JOINTS", "WEIGHTS"].iter().all(|kind| attributes.contains_key(&format!("{kind}_{set}")));
        if sets == 0 || count("WEIGHTS_") != sets || !(0..sets).all(is_there) {
            return Ok(false);
        }
        let own = self.split.positions().len() - self.split.halved().len();
        let mut influences: Vec<Influences> = vec![Vec::new(); own];
        for set in 0..sets {
            self.read_influences(set, attributes, &mut influences)?;
        }
        append_influences(&mut influences, 4 * sets, self.split.halved());
        for set in 0..sets {
            let row = |of: &Influences| -> [(u16, f32); 4] {
                std::array::from_fn(|k| of.get(4 * set + k).copied().unwrap_or((0, 0.0)))
            };
            let rows: Vec<_> = influences.iter().map(row).collect();
            let [joints, weights] = ["JOINTS", "WEIGHTS"].map(|kind| format!("{kind}_{set}"));
            let index = index_of(&attributes[&joints]);
            let size = self.accessors().size(index, self.source)?;
            let bytes: Vec<u8> = match size {
                4 => rows.as_flattened().iter().map(|&(joint, _)| joint as u8).collect(),
                _ => rows.as_flattened().iter().flat_map(|(joint, _)| joint.to_le_bytes()).collect(),
            };
            attributes.insert(joints, json!(self.push_attribute(index, &bytes, size)));
            let bytes: Vec<u8> = rows.as_flattened().iter().flat_map(|(_, weight)| weight.to_le_bytes()).collect();
            let accessor = self.push_attribute(index_of(&attributes[&weights]), &bytes, 16);
            self.declare_float(accessor, None);
            attributes.insert(weights, json!(accessor));
        }
        Ok(true)
    }

    /// Appends one set of joints and weights to those of each vertex.
    fn read_influences(
        &self,
        set: usize,
        attributes: &Map<String, Value>,
        influences: &mut [Influences],
    ) -> Result<(), SceneError> {
        let [joints, weights] = ["JOINTS", "WEIGHTS"].map(|kind| format!("{kind}_{set}"));
        let at = [&joints, &weights].map(|name| index_of(&attributes[name]));
        at.into_iter().try_for_each(|index| self.check_count(index))?;
        let of_joints = self.accessors().joints(&joints, at[0], self.source)?;
        let of_weights = self.accessors().vectors::<4>(&weights, at[1], self.source)?;
        for ((all, joints), weights) in influences.iter_mut().zip(of_joints).zip(of_weights) {
            all.extend(joints.into_iter().zip(weights));
        }
        Ok(())
    }

    /// Adds an accessor of all vertices, in all else like another.
    fn push_attribute(&mut self, like: Index<Accessor>, bytes: &[u8], size: usize) -> usize {
        let mut accessor = self.file.json["accessors"][like.value()].clone();
        if let Value::Object(members) = &mut accessor {
            ["byteOffset", "sparse", "min", "max"].iter().for_each(|name| drop(members.remove(*name)));
        }
        let view = self.file.push_elements(bytes, size);
        self.file.json["bufferViews"][view]["target"] = json!(ARRAY_BUFFER);
        accessor["count"] = json!(self.split.positions().len());
        accessor["bufferView"] = json!(view);
        push(&mut self.file.json, "accessors", accessor)
    }

    /// Says that an accessor holds floats, and between which bounds if these are to be known.
    fn declare_float(&mut self, accessor: usize, values: Option<(&Vec<f32>, usize)>) {
        let json = &mut self.file.json["accessors"][accessor];
        json["componentType"] = json!(FLOAT);
        json.as_object_mut().map(|members| members.remove("normalized"));
        if let Some((values, size)) = values {
            let bound = |k: usize, of: fn(f32, f32) -> f32| values.iter().skip(k).step_by(size).copied().reduce(of);
            json["min"] = (0..size).map(|k| json!(bound(k, f32::min))).collect();
            json["max"] = (0..size).map(|k| json!(bound(k, f32::max))).collect();
        }
    }

    /// Writes the triangles; returns their accessor.
    fn write_triangles(&mut self, turned: bool) -> usize {
        let corners = |&[a, b, c]: &[u32; 3]| if turned { [a, c, b] } else { [a, b, c] };
        let indices: Vec<u32> = self.split.triangles().iter().flat_map(corners).collect();
        let is_short = self.split.positions().len() <= SHORT_INDICES;
        let (component, bytes): (_, Vec<u8>) = match is_short {
            true => (5123, indices.iter().flat_map(|&index| (index as u16).to_le_bytes()).collect()),
            false => (5125, indices.iter().flat_map(|index| index.to_le_bytes()).collect()),
        };
        let view = self.file.push_view(bytes);
        self.file.json["bufferViews"][view]["target"] = json!(ELEMENT_ARRAY_BUFFER);
        let count = indices.len();
        let accessor = json!({"bufferView": view, "componentType": component, "count": count, "type": "SCALAR"});
        push(&mut self.file.json, "accessors", accessor)
    }
}

/// Appends the bytes of a number, a fraction of the largest of its kind unless that is a float.
fn push_encoded(bytes: &mut Vec<u8>, value: f32, kind: ComponentType) {
    let whole = |largest: f64| (f64::from(value) * largest).round();
    match kind {
        ComponentType::F32 => bytes.extend(value.to_le_bytes()),
        ComponentType::I8 => bytes.extend((whole(127.0) as i8).to_le_bytes()),
        ComponentType::U8 => bytes.push(whole(255.0) as u8),
        ComponentType::I16 => bytes.extend((whole(32767.0) as i16).to_le_bytes()),
        ComponentType::U16 => bytes.extend((whole(65535.0) as u16).to_le_bytes()),
        ComponentType::U32 => bytes.extend((whole(4294967295.0) as u32).to_le_bytes()),
    }
}
