//! glTF document: a whole file, to be extended and written again.

use std::path::Path;

use serde_json::{Map, Value, json};

use crate::files::gltf::files;
use crate::files::source::{Source, folder_of, read_file};
use crate::{SceneError, SceneReadOptions};

/// The JSON of a glTF file with all its members, and all its bytes in one buffer: what a .glb holds.
///
/// Referenced buffers and pictures are embedded in the buffer; nothing else has changed.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfDocument {
    /// The JSON. Its one buffer is [`Self::bytes`], without a URI.
    pub json: Value,
    /// The buffer.
    pub bytes: Vec<u8>,
}

/// Extensions of buffer views that refer to a buffer themselves.
const VIEW_EXTENSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

impl GltfDocument {
    /// Reads a .gltf or .glb file with the files it references; returns a note for each that could not be embedded.
    ///
    /// # Errors
    /// As [`read_scene`](crate::read_scene) for the file and its buffers. A missing picture is no error: its URI is
    /// kept.
    pub fn read(path: impl AsRef<Path>) -> Result<(Self, Vec<String>), SceneError> {
        let path = path.as_ref();
        let (name, bytes) = read_file(path)?;
        let mut source = Source::new(&name, folder_of(path), &SceneReadOptions::default());
        let buffers = files::read(&bytes, &mut source)?.buffers;
        let json = files::read_json(&bytes, &source)?;
        let mut document = Self { json, bytes: Vec::new() };
        document.merge_buffers(buffers).map_err(|message| source.invalid(message))?;
        let notes = document.embed_images(&source);
        document.declare_buffer();
        Ok((document, notes))
    }

    /// Adds bytes, at a multiple of four, and a buffer view of them; returns its index.
    pub(crate) fn push_view(&mut self, bytes: &[u8]) -> usize {
        self.align();
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        push(&mut self.json, "bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    /// Writes the length of the buffer to the JSON.
    pub(crate) fn declare_buffer(&mut self) {
        if self.bytes.is_empty() {
            return;
        }
        let length = self.bytes.len();
        let first = self.json["buffers"].get(0).cloned();
        let mut buffer = first.unwrap_or_else(|| Value::Object(Map::new()));
        buffer["byteLength"] = json!(length);
        self.json["buffers"] = json!([buffer]);
    }

    /// Pads the buffer to a multiple of four, as four-byte numbers need.
    fn align(&mut self) {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }

    /// Concatenates the buffers; of their other JSON members, the first buffer's are kept.
    fn merge_buffers(&mut self, buffers: Vec<Vec<u8>>) -> Result<(), String> {
        let mut starts = Vec::new();
        for buffer in buffers {
            self.align();
            starts.push(self.bytes.len() as u64);
            self.bytes.extend(buffer);
        }
        for (i, view) in items(&mut self.json, "bufferViews").enumerate() {
            move_view(view, &starts).ok_or_else(|| format!("buffer view {i} lies in no buffer of the file"))?;
            for name in VIEW_EXTENSIONS {
                if let Some(compressed) = view.get_mut("extensions").and_then(|e| e.get_mut(name)) {
                    move_view(compressed, &starts)
                        .ok_or_else(|| format!("{name} of buffer view {i} lies in no buffer of the file"))?;
                }
            }
        }
        if let Some(Value::Object(first)) = items(&mut self.json, "buffers").next() {
            first.remove("uri");
        }
        Ok(())
    }

    fn embed_images(&mut self, source: &Source<'_>) -> Vec<String> {
        let mut notes = Vec::new();
        for i in 0..items(&mut self.json, "images").count() {
            let Some(Value::String(uri)) = self.json["images"][i].get("uri").cloned() else { continue };
            let bytes = match files::read_uri(&uri, source) {
                Ok(bytes) => bytes,
                Err(error) => {
                    notes.push(format!("image {i} stays outside of the file: {error}"));
                    continue;
                }
            };
            let Some(kind) = media_type(&uri, &bytes) else {
                notes.push(format!("image {i} stays outside of the file: it is of no known kind"));
                continue;
            };
            let view = self.push_view(&bytes);
            if let Value::Object(image) = &mut self.json["images"][i] {
                image.remove("uri");
                image.insert("mimeType".to_string(), json!(kind));
                image.insert("bufferView".to_string(), json!(view));
            }
        }
        notes
    }
}

/// The objects of an array of the file; none if it has no such array.
fn items<'a>(json: &'a mut Value, array: &str) -> impl Iterator<Item = &'a mut Value> {
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

fn move_view(view: &mut Value, starts: &[u64]) -> Option<()> {
    let start = starts.get(usize::try_from(view.get("buffer")?.as_u64()?).ok()?)?;
    let offset = view.get("byteOffset").map_or(Some(0), Value::as_u64)?;
    view["byteOffset"] = json!(offset.checked_add(*start)?);
    view["buffer"] = json!(0);
    Some(())
}

/// The media type of a picture, by its bytes or else by its URI.
fn media_type(uri: &str, bytes: &[u8]) -> Option<String> {
    let by_bytes = [
        (&b"\x89PNG"[..], "image/png"),
        (&[0xFF, 0xD8, 0xFF], "image/jpeg"),
        (&[0xAB, b'K', b'T', b'X', b' ', b'2', b'0'], "image/ktx2"),
    ];
    if let Some((_, kind)) = by_bytes.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Some((*kind).to_string());
    }
    if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        return Some("image/webp".to_string());
    }
    let kind = uri.strip_prefix("data:")?.split([';', ',']).next()?;
    kind.starts_with("image/").then(|| kind.to_string())
}
