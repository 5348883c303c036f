//! Validator of .glb files, by the rules of the Khronos validator for containers, buffers and vertices.

use gltf_json::validation::Validate;
use gltf_json::{Path, Root};
use serde_json::Value;

/// The rows of bytes that an accessor names: those of a vertex, or an index.
struct Rows<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
    component: u64,
    components: usize,
}

/// Bytes of a number, by the number of its type in glTF.
fn size_of(component: u64) -> Option<usize> {
    Some(match component {
        5120 | 5121 => 1,
        5122 | 5123 => 2,
        5125 | 5126 => 4,
        _ => return None,
    })
}

const FLOAT: u64 = 5126;

/// The faults of a .glb file, a line each, none if it is valid. Checked are
///
/// * the container: magic, version, lengths, chunks at multiples of four and what fills them up;
/// * the JSON, by the crate `gltf-json`: types, what must be there, indices in range;
/// * buffer views within their buffer, accessors within their view; alignment of both; strides that are multiples of
///   four, from 4 to 252, and given where attributes share a view;
/// * attributes: names of glTF's or beginning with `_`, as many values for each, positions, normals and tangents of the
///   right type, finite floats, unit normals, `min` and `max` of positions as they are;
/// * indices: unsigned, tightly packed, of vertices that there are.
///
/// Not checked is what a scene without animation, skins and morph targets lacks.
#[must_use]
pub fn glb_faults(bytes: &[u8]) -> Vec<String> {
    let (json, buffer) = match chunks(bytes) {
        Ok(chunks) => chunks,
        Err(fault) => return vec![fault],
    };
    let root = match Root::from_slice(json) {
        Ok(root) => root,
        Err(error) => return vec![format!("the JSON is not that of glTF: {error}")],
    };
    let mut faults = Vec::new();
    root.validate(&root, Path::new, &mut |path, error| faults.push(format!("{}: {error}", path())));
    let Ok(json) = serde_json::from_slice::<Value>(json) else { return vec!["the JSON is none".to_owned()] };
    let mut check = Check { json: &json, buffer, faults };
    check.buffer();
    (0..len(&json["bufferViews"])).for_each(|view| check.view(view));
    for accessor in 0..len(&json["accessors"]) {
        check.rows(accessor);
    }
    check.primitives();
    // Accessors that attributes use are looked at once more.
    check.faults.sort();
    check.faults.dedup();
    check.faults
}

/// The JSON and the buffer of the container.
pub(crate) fn chunks(bytes: &[u8]) -> Result<(&[u8], &[u8]), String> {
    let word = |at: usize| {
        let word = bytes.get(at..at + 4).and_then(|word| word.first_chunk::<4>());
        word.map(|word| u32::from_le_bytes(*word) as usize).ok_or(format!("the file ends before byte {}", at + 4))
    };
    let (magic, version, length) = (word(0)?, word(4)?, word(8)?);
    if magic != u32::from_le_bytes(*b"glTF") as usize || version != 2 || length != bytes.len() {
        return Err(format!(
            "the header is not that of glTF 2 with {} bytes: {magic:x}, {version}, {length}",
            bytes.len()
        ));
    }
    let chunk = |at: usize, kind: &[u8; 4], fill: u8| {
        let (length, found) = (word(at)?, word(at + 4)?);
        let Some(chunk) = bytes.get(at + 8..at + 8 + length) else { return Err(format!("chunk at {at} is cut off")) };
        if found != u32::from_le_bytes(*kind) as usize || !length.is_multiple_of(4) {
            return Err(format!("chunk at {at}: kind {found:x}, {length} bytes"));
        }
        // At most three bytes fill it up, which its content cannot tell from others.
        let filled = chunk.iter().rev().take_while(|&&b| b == fill).count();
        if fill == b' ' && filled > 3 {
            return Err(format!("chunk at {at} is filled up with {filled} bytes"));
        }
        Ok(chunk)
    };
    let json = chunk(12, b"JSON", b' ')?;
    let second = 20 + json.len();
    let buffer = if second == bytes.len() { &[][..] } else { chunk(second, b"BIN\0", 0)? };
    if second != bytes.len() && second + 8 + buffer.len() != bytes.len() {
        return Err("there is something behind the two chunks".to_owned());
    }
    Ok((json, buffer))
}

/// The number of items of an array; 0 if it is not there.
fn len(array: &Value) -> usize {
    array.as_array().map_or(0, Vec::len)
}

/// A member that is a whole number; `default` where it is not there.
fn whole(object: &Value, member: &str, default: usize) -> usize {
    object[member].as_u64().map_or(default, |n| n as usize)
}

struct Check<'a> {
    json: &'a Value,
    buffer: &'a [u8],
    faults: Vec<String>,
}

impl<'a> Check<'a> {
    fn expect(&mut self, is_right: bool, fault: impl FnOnce() -> String) {
        if !is_right {
            self.faults.push(fault());
        }
    }

    fn buffer(&mut self) {
        let (buffers, chunk) = (&self.json["buffers"], self.buffer.len());
        if let Some(buffer) = buffers.get(0).filter(|buffer| buffer["uri"].is_null()) {
            let length = whole(buffer, "byteLength", 0);
            self.expect(length <= chunk && chunk < length + 4, || {
                format!("buffer 0: {length} bytes, its chunk {chunk}")
            });
        } else {
            self.expect(chunk == 0, || "a chunk of bytes and no buffer that is it".to_owned());
        }
    }

    fn view(&mut self, index: usize) {
        let view = &self.json["bufferViews"][index];
        let (offset, length) = (whole(view, "byteOffset", 0), whole(view, "byteLength", 0));
        let buffer = whole(&self.json["buffers"][whole(view, "buffer", usize::MAX)], "byteLength", 0);
        let end = offset.saturating_add(length);
        self.expect(length > 0 && end <= buffer, || format!("view {index}: bytes {offset} to {end} of {buffer}"));
        if let Some(stride) = view["byteStride"].as_u64() {
            let is_right = stride.is_multiple_of(4) && (4..=252).contains(&stride);
            self.expect(is_right, || format!("view {index}: a stride of {stride}"));
        }
    }

    /// The rows of an accessor; none if they are not there, which is a fault unless they are zeros or not in this file.
    fn rows(&mut self, index: usize) -> Option<Rows<'a>> {
        let (json, buffer) = (self.json, self.buffer);
        let accessor = &json["accessors"][index];
        let component = accessor["componentType"].as_u64().unwrap_or(0);
        let components = match accessor["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC2") => 2,
            Some("VEC3") => 3,
            Some("VEC4") => 4,
            _ => 0,
        };
        let count = whole(accessor, "count", 0);
        let Some(size) = size_of(component).filter(|_| components > 0 && count > 0) else {
            self.faults.push(format!("accessor {index}: {count} times {} of {component}", accessor["type"]));
            return None;
        };
        for bound in ["min", "max"] {
            let found = &accessor[bound];
            let is_right = found.is_null() || len(found) == components;
            self.expect(is_right, || format!("accessor {index}: {bound} is {found}"));
        }
        let view = &json["bufferViews"][accessor["bufferView"].as_u64()? as usize];
        if !json["buffers"][whole(view, "buffer", 0)]["uri"].is_null() {
            return None;
        }
        let stride = whole(view, "byteStride", size * components);
        let (start, offset) = (whole(view, "byteOffset", 0), whole(accessor, "byteOffset", 0));
        let is_aligned = [offset, start + offset, stride].iter().all(|n| n.is_multiple_of(size));
        self.expect(is_aligned, || format!("accessor {index}: {start} + {offset}, every {stride}, of {size} bytes"));
        let end = (count - 1).saturating_mul(stride).saturating_add(offset).saturating_add(size * components);
        let length = whole(view, "byteLength", 0);
        let rows = buffer.get(start..).and_then(|bytes| bytes.get(offset..end)).filter(|_| end <= length);
        self.expect(rows.is_some() && stride >= size * components, || {
            format!("accessor {index}: bytes {offset} to {end} of a view of {length}, every {stride}")
        });
        rows.map(|bytes| Rows { bytes, stride, count, component, components })
    }

    fn primitives(&mut self) {
        let json = self.json;
        let mut users = vec![Vec::new(); len(&json["bufferViews"])];
        for (m, mesh) in json["meshes"].as_array().into_iter().flatten().enumerate() {
            for (p, primitive) in mesh["primitives"].as_array().into_iter().flatten().enumerate() {
                let place = format!("mesh {m}, primitive {p}");
                for accessor in self.attributes(&place, primitive) {
                    let view = json["accessors"][accessor]["bufferView"].as_u64();
                    if let Some(users) = view.and_then(|view| users.get_mut(view as usize)) {
                        users.push(accessor);
                    }
                }
            }
        }
        for (view, mut users) in users.into_iter().enumerate() {
            users.sort_unstable();
            users.dedup();
            let has_stride = json["bufferViews"][view]["byteStride"].is_u64();
            self.expect(users.len() < 2 || has_stride, || format!("view {view}: no stride for accessors {users:?}"));
        }
    }

    /// Checks a primitive; the accessors of its attributes.
    fn attributes(&mut self, place: &str, primitive: &Value) -> Vec<usize> {
        let mut accessors = Vec::new();
        let mut vertices = None;
        for (name, accessor) in primitive["attributes"].as_object().into_iter().flatten() {
            let accessor = accessor.as_u64().unwrap_or(u64::MAX) as usize;
            let at = format!("{place}, {name}");
            self.expect(is_known(name), || format!("{at}: no attribute of glTF, and no `_` before it"));
            let Some(rows) = self.rows(accessor) else { continue };
            accessors.push(accessor);
            let known = *vertices.get_or_insert(rows.count);
            self.expect(known == rows.count, || format!("{at}: {} values beside {known}", rows.count));
            let offset = whole(&self.json["accessors"][accessor], "byteOffset", 0);
            let is_aligned = rows.stride.is_multiple_of(4) && offset.is_multiple_of(4);
            self.expect(is_aligned, || format!("{at}: offset {offset}, every {} bytes", rows.stride));
            self.values(&at, name, accessor, &rows);
        }
        let positions = &primitive["attributes"]["POSITION"];
        self.expect(positions.is_u64(), || format!("{place}: no POSITION"));
        if let Some(indices) = primitive["indices"].as_u64() {
            self.indices(place, indices as usize, vertices.unwrap_or(0));
        }
        accessors
    }

    fn values(&mut self, at: &str, name: &str, accessor: usize, rows: &Rows<'_>) {
        let shape = (rows.component, rows.components);
        let is_right = match name {
            "POSITION" | "NORMAL" => shape == (FLOAT, 3),
            "TANGENT" => shape == (FLOAT, 4),
            _ => true,
        };
        self.expect(is_right, || format!("{at}: {} numbers of type {}", rows.components, rows.component));
        if rows.component != FLOAT || !is_right {
            return;
        }
        let (mut min, mut max) = (vec![f32::INFINITY; rows.components], vec![f32::NEG_INFINITY; rows.components]);
        for (i, row) in rows.floats().enumerate() {
            self.expect(row.iter().all(|c| c.is_finite()), || format!("{at}: {row:?} at {i}"));
            let length = row.iter().take(3).map(|c| c * c).sum::<f32>().sqrt();
            self.expect(name != "NORMAL" || (length - 1.0).abs() < 5e-4, || format!("{at}: length {length} at {i}"));
            for (k, c) in row.iter().enumerate() {
                (min[k], max[k]) = (min[k].min(*c), max[k].max(*c));
            }
        }
        if name == "POSITION" {
            for (bound, found) in [("min", min), ("max", max)] {
                let said = self.json["accessors"][accessor][bound].as_array().into_iter().flatten();
                let said: Vec<f32> = said.map(|c| c.as_f64().unwrap_or(f64::NAN) as f32).collect();
                self.expect(said == found, || format!("{at}: {bound} is {found:?}, not {said:?}"));
            }
        }
    }

    fn indices(&mut self, place: &str, accessor: usize, vertices: usize) {
        let Some(rows) = self.rows(accessor) else { return };
        let size = size_of(rows.component).unwrap_or(0);
        let is_right = rows.components == 1 && [5121, 5123, 5125].contains(&rows.component) && rows.stride == size;
        self.expect(is_right, || format!("{place}: indices of type {}, every {} bytes", rows.component, rows.stride));
        let index = |bytes: &[u8]| bytes.iter().rev().fold(0, |index, &b| index << 8 | usize::from(b));
        let largest = rows.bytes.chunks(size.max(1)).map(index).max().unwrap_or(0);
        self.expect(largest < vertices, || format!("{place}: index {largest} of {vertices} vertices"));
    }
}

impl Rows<'_> {
    fn floats(&self) -> impl Iterator<Item = Vec<f32>> {
        let row = |bytes: &[u8]| {
            let numbers = bytes.as_chunks().0.iter().take(self.components);
            numbers.map(|b| f32::from_le_bytes(*b)).collect()
        };
        self.bytes.chunks(self.stride).map(row)
    }
}

/// Names that glTF gives, and those of applications.
fn is_known(name: &str) -> bool {
    let is_numbered = |prefix: &str| name.strip_prefix(prefix).is_some_and(|n| n.parse::<u8>().is_ok());
    matches!(name, "POSITION" | "NORMAL" | "TANGENT")
        || name.starts_with('_')
        || ["TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"].into_iter().any(is_numbered)
}
