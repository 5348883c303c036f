//! glTF files: JSON and buffers, and changes of both.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::ops::Range;

use serde_json::{Value, json};

use crate::error::SceneError;
use crate::files::gltf::root::Root;
use crate::files::gltf::uri::read_uri;
use crate::files::gltf::{container, extensions};
use crate::files::source::Source;

/// JSON and buffers of a glTF file. Only the shape of the JSON has been checked.
pub(crate) struct GltfFile {
    /// The JSON with all its members.
    pub(crate) json: Value,
    /// The members of the JSON that are used.
    pub(crate) root: Root,
    /// The bytes of each buffer; empty for one outside of the file that nothing uses.
    pub(crate) buffers: Vec<Vec<u8>>,
}

/// Extensions of buffer views that refer to a buffer themselves.
pub(crate) const VIEW_EXTENSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

impl GltfFile {
    /// Reads JSON and buffers, from a .glb or from a .gltf with the files it references.
    ///
    /// Bytes that are given away become the buffer of a .glb: they are not held twice.
    pub(crate) fn read(bytes: Cow<'_, [u8]>, source: &mut Source<'_>) -> Result<Self, SceneError> {
        let (text, blob) = container::split(&bytes, source)?;
        let text = &bytes[text];
        if !text.trim_ascii_start().starts_with(b"{") {
            return Err(source.invalid("expected glTF, which begins with `glTF` or is JSON, found something else"));
        }
        let json: Value = serde_json::from_slice(text)
            .map_err(|error| source.invalid(format!("expected glTF, found an error: {error}")))?;
        extensions::check(&json, source)?;
        check_objects(&json, source)?;
        let root = Root::of(&json, source)?;
        let mut file = Self { json, root, buffers: Vec::new() };
        let blob = blob.map(|range| part_of(bytes, range, source)).transpose()?;
        file.read_buffers(blob, source)?;
        Ok(file)
    }

    fn read_buffers(&mut self, mut blob: Option<Vec<u8>>, source: &mut Source<'_>) -> Result<(), SceneError> {
        let used = self.used_buffers();
        for (i, buffer) in self.root.buffers.iter().enumerate() {
            let mut data = match (&buffer.uri, blob.take_if(|_| i == 0 && buffer.uri.is_none())) {
                // What nothing uses is not read: it would only be copied to where it can be seen.
                (Some(uri), _) if !uri.starts_with("data:") && !used.contains(&i) => {
                    source.note(format!("buffer {i} is not used, and was not read"));
                    self.buffers.push(Vec::new());
                    continue;
                }
                (Some(uri), _) => read_uri(uri, source)?,
                (None, Some(blob)) => blob,
                // Where the views of a buffer are compressed, it need not be there.
                (None, _) if !used.contains(&i) && self.is_fallback(i) => {
                    self.buffers.push(Vec::new());
                    continue;
                }
                _ => return Err(source.invalid(format!("buffer {i} has neither a URI nor a chunk of a .glb"))),
            };
            let (expected, found) = (buffer.byte_length.0, data.len());
            if (found as u64) < expected {
                return Err(source.invalid(format!("expected {expected} bytes in buffer {i}, found {found}")));
            }
            data.truncate(expected as usize);
            self.buffers.push(data);
        }
        Ok(())
    }

    /// The buffers that buffer views are read from: where one is compressed, the buffer of its extension.
    fn used_buffers(&self) -> BTreeSet<usize> {
        let views = self.json["bufferViews"].as_array().into_iter().flatten();
        let buffers = views.filter_map(|view| {
            let compressed = VIEW_EXTENSIONS.iter().find_map(|name| view["extensions"][name]["buffer"].as_u64());
            compressed.or_else(|| view["buffer"].as_u64())
        });
        buffers.map(|buffer| buffer as usize).collect()
    }

    fn is_fallback(&self, buffer: usize) -> bool {
        let extensions = &self.json["buffers"][buffer]["extensions"];
        VIEW_EXTENSIONS.iter().any(|name| extensions[name]["fallback"] == true)
    }

    /// Empties the buffers that nothing uses any more.
    #[cfg(feature = "compressed")]
    pub(crate) fn drop_unused_buffers(&mut self) {
        let used = self.used_buffers();
        let buffers = self.buffers.iter_mut().enumerate();
        buffers.filter(|(i, _)| !used.contains(i)).for_each(|(_, bytes)| *bytes = Vec::new());
    }

    /// Adds elements of `size` bytes, each at a multiple of four as attributes have to be; returns their view's index.
    pub(crate) fn push_elements(&mut self, bytes: &[u8], size: usize) -> usize {
        let stride = size.next_multiple_of(4);
        let mut padded = Vec::with_capacity(bytes.len() / size.max(1) * stride);
        for element in bytes.chunks(size.max(1)) {
            padded.extend_from_slice(element);
            padded.resize(padded.len().next_multiple_of(4), 0);
        }
        let view = self.push_view(padded);
        if stride != size {
            self.json["bufferViews"][view]["byteStride"] = json!(stride);
        }
        view
    }

    /// Adds a buffer of these bytes, and a buffer view of it; returns the view's index.
    pub(crate) fn push_view(&mut self, bytes: Vec<u8>) -> usize {
        let length = bytes.len();
        self.buffers.push(bytes);
        let buffer = push(&mut self.json, "buffers", json!({"byteLength": length}));
        push(&mut self.json, "bufferViews", json!({"buffer": buffer, "byteLength": length}))
    }

    /// Reads the members that are used from the JSON, after it was changed.
    pub(crate) fn update(&mut self, source: &Source<'_>) -> Result<(), SceneError> {
        self.root = Root::of(&self.json, source)?;
        Ok(())
    }
}

/// A part of bytes: of those that are given away in the same memory, of others a copy.
fn part_of(bytes: Cow<'_, [u8]>, range: Range<usize>, source: &mut Source<'_>) -> Result<Vec<u8>, SceneError> {
    match bytes {
        Cow::Owned(mut bytes) => {
            bytes.truncate(range.end);
            bytes.drain(..range.start);
            Ok(bytes)
        }
        Cow::Borrowed(bytes) => {
            source.count_bytes(range.len() as u64)?;
            Ok(bytes[range].to_vec())
        }
    }
}

/// The arrays of a file whose items are objects.
const ARRAYS_OF_OBJECTS: [&str; 10] =
    ["accessors", "bufferViews", "buffers", "images", "materials", "meshes", "nodes", "samplers", "scenes", "textures"];

/// Refuses objects that are written as arrays, which serde would read member by member.
fn check_objects(json: &Value, source: &Source<'_>) -> Result<(), SceneError> {
    for name in ARRAYS_OF_OBJECTS {
        for (at, item) in json[name].as_array().into_iter().flatten().enumerate() {
            let mut primitives = item["primitives"].as_array().into_iter().flatten();
            if !item.is_object() || !primitives.all(Value::is_object) {
                return Err(source.invalid(format!(
                    "expected glTF, found an error at {name}[{at}]: expected objects, found another kind of JSON"
                )));
            }
        }
    }
    Ok(())
}

/// The objects of an array of the file; none if it has no such array.
pub(crate) fn items<'a>(json: &'a mut Value, array: &str) -> impl Iterator<Item = &'a mut Value> {
    json.get_mut(array).and_then(Value::as_array_mut).into_iter().flatten()
}

/// Appends to an array of the file, which is created if missing; returns the new index.
pub(crate) fn push(json: &mut Value, array: &str, item: Value) -> usize {
    match &mut json[array] {
        Value::Array(items) => items.push(item),
        missing => *missing = json!([item]),
    }
    json[array].as_array().map_or(0, |items| items.len() - 1)
}

/// Takes an extension off the lists of those that a file uses and requires.
pub(crate) fn forget_extension(json: &mut Value, name: &str) {
    let Value::Object(file) = json else { return };
    for list in ["extensionsUsed", "extensionsRequired"] {
        if let Some(Value::Array(names)) = file.get_mut(list) {
            names.retain(|found| found != name);
            // An empty list is not valid.
            if names.is_empty() {
                file.remove(list);
            }
        }
    }
}

/// Takes an extension out of an object; `None` without it.
pub(crate) fn take_extension(object: &mut Value, name: &str) -> Option<Value> {
    let object = object.as_object_mut()?;
    let extensions = object.get_mut("extensions")?.as_object_mut()?;
    let found = extensions.remove(name);
    if extensions.is_empty() {
        object.remove("extensions");
    }
    found
}
