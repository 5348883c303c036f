//! glTF files: JSON and buffers, with what they store compressed or leave to the reader made plain.

use serde_json::{Value, json};

use crate::SceneError;
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
    pub(crate) fn read(bytes: &[u8], source: &mut Source<'_>) -> Result<Self, SceneError> {
        let (text, blob) = container::split(bytes, source)?;
        let json: Value = serde_json::from_slice(text)
            .map_err(|error| source.invalid(format!("expected glTF, found an error: {error}")))?;
        extensions::check(&json, source)?;
        let root = Root::of(&json, source)?;
        let mut file = Self { json, root, buffers: Vec::new() };
        file.read_buffers(blob, source)?;
        Ok(file)
    }

    fn read_buffers(&mut self, blob: Option<&[u8]>, source: &mut Source<'_>) -> Result<(), SceneError> {
        let used = self.used_buffers();
        for (i, buffer) in self.root.buffers.iter().enumerate() {
            let mut data = match (&buffer.uri, blob) {
                // What nothing uses is not read: it would only be copied to where it can be seen.
                (Some(uri), _) if !uri.starts_with("data:") && !used.contains(&i) => {
                    source.note(format!("buffer {i} is not used, and was not read"));
                    self.buffers.push(Vec::new());
                    continue;
                }
                (Some(uri), _) => read_uri(uri, source)?,
                (None, Some(blob)) if i == 0 => blob.to_vec(),
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

    /// The buffers that a buffer view names, be it in an extension.
    fn used_buffers(&self) -> Vec<usize> {
        let views = self.json["bufferViews"].as_array().into_iter().flatten();
        let buffers = views.flat_map(|view| {
            let compressed = VIEW_EXTENSIONS.map(|name| &view["extensions"][name]["buffer"]);
            compressed.into_iter().chain([&view["buffer"]]).filter_map(Value::as_u64)
        });
        buffers.map(|buffer| buffer as usize).collect()
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
