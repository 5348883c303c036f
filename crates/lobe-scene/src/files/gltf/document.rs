//! glTF document: a whole file, to be extended and written again.

use serde_json::{Map, Value, json};

use crate::error::SceneError;
use crate::files::gltf::files::{GltfFile, VIEW_EXTENSIONS, items, push};
use crate::files::gltf::uri::read_uri;
use crate::files::source::Source;

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

impl GltfDocument {
    /// The file with its buffers put together, and pictures beside it that [`embed_images`] has not left out.
    pub(crate) fn of_file(file: GltfFile, source: &Source<'_>) -> Result<Self, SceneError> {
        // Where several buffers become one, it stands beside them for a moment.
        if file.buffers.iter().filter(|buffer| !buffer.is_empty()).count() > 1 {
            source.check_bytes(length_of(&file.buffers) as u64)?;
        }
        let mut document = Self { json: file.json, bytes: Vec::new() };
        document.merge_buffers(file.buffers).map_err(|message| source.invalid(message))?;
        document.declare_buffer();
        Ok(document)
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
        let (mut starts, whole) = (Vec::new(), length_of(&buffers));
        for buffer in buffers {
            self.align();
            starts.push(self.bytes.len() as u64);
            // The first is moved: it is often the only one, and large.
            if self.bytes.is_empty() {
                self.bytes = buffer;
            } else {
                self.bytes.reserve_exact(whole - self.bytes.len());
                self.bytes.extend(buffer);
            }
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
}

/// The length of buffers that are put together, each at a multiple of four.
fn length_of(buffers: &[Vec<u8>]) -> usize {
    buffers.iter().map(|buffer| buffer.len().next_multiple_of(4)).sum()
}

/// Makes pictures beside the file part of its buffers, with a note on each that is kept by its URI.
pub(crate) fn embed_images(file: &mut GltfFile, source: &mut Source<'_>) -> Result<(), SceneError> {
    for i in 0..file.root.images.len() {
        let Some(uri) = file.root.images[i].uri.clone() else { continue };
        let bytes = match read_uri(&uri, source) {
            Ok(bytes) => bytes,
            Err(error @ SceneError::Refused { .. }) => return Err(error),
            Err(error) => {
                source.note(format!("image {i} stays outside of the file: {error}"));
                continue;
            }
        };
        let Some(kind) = media_type(&uri, &bytes) else {
            source.note(format!("image {i} stays outside of the file: it is of no known kind"));
            continue;
        };
        let view = file.push_view(bytes);
        if let Value::Object(image) = &mut file.json["images"][i] {
            image.remove("uri");
            image.insert("mimeType".to_string(), json!(kind));
            image.insert("bufferView".to_string(), json!(view));
        }
    }
    file.update(source)
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
