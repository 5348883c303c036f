//! `EXT_meshopt_compression`: buffer views stored by meshoptimizer, made plain.

use std::panic::{AssertUnwindSafe, catch_unwind};

use meshoptimizer_rs::codec::{Filter, Mode, decode_buffer_view};
use meshoptimizer_rs::{Limits, Workspace};
use serde_json::{Value, json};

use crate::error::SceneError;
use crate::files::gltf::files::{GltfFile, VIEW_EXTENSIONS, forget_extension, items, push, take_extension};
use crate::files::source::Source;

/// The most bytes of an element: a VEC4 of floats, with others beside it.
const LARGEST_ELEMENT: usize = 256;

/// Gives compressed buffer views the bytes that they stand for; what they were made of is dropped.
pub(crate) fn decode(file: &mut GltfFile, source: &mut Source<'_>) -> Result<(), SceneError> {
    let mut found = Vec::new();
    for (index, view) in items(&mut file.json, "bufferViews").enumerate() {
        for name in VIEW_EXTENSIONS {
            found.extend(take_extension(view, name).map(|compressed| (index, compressed)));
        }
    }
    if found.is_empty() {
        return Ok(());
    }
    for (index, compressed) in found {
        let invalid = |message: String, source: &Source<'_>| {
            source.invalid(format!("meshopt compression of buffer view {index}: {message}"))
        };
        let size = size_of(&compressed, source.limit()).map_err(|message| invalid(message, source))?;
        source.count_bytes((size[0] as u64).saturating_mul(size[1] as u64))?;
        let bytes = decode_view(&file.buffers, &compressed, size).map_err(|message| invalid(message, source))?;
        let length = bytes.len();
        file.buffers.push(bytes);
        let buffer = push(&mut file.json, "buffers", json!({"byteLength": length}));
        let Value::Object(view) = &mut file.json["bufferViews"][index] else { continue };
        view.insert("buffer".to_owned(), json!(buffer));
        view.insert("byteLength".to_owned(), json!(length));
        view.remove("byteOffset");
        // Only attributes have a stride of their own.
        if compressed["mode"] != "ATTRIBUTES" {
            view.remove("byteStride");
        } else if !view.contains_key("byteStride") {
            // Elements may have padding, which accessors do not know of.
            view.insert("byteStride".to_owned(), compressed["byteStride"].clone());
        }
    }
    for buffer in items(&mut file.json, "buffers") {
        for name in VIEW_EXTENSIONS {
            take_extension(buffer, name);
        }
    }
    VIEW_EXTENSIONS.iter().for_each(|name| forget_extension(&mut file.json, name));
    file.drop_unused_buffers();
    file.update(source)
}

fn number(compressed: &Value, name: &str) -> Result<usize, String> {
    let value = compressed.get(name).and_then(Value::as_u64).and_then(|value| usize::try_from(value).ok());
    value.ok_or_else(|| format!("expected a whole number as {name}, found {}", compressed[name]))
}

/// The number of elements of a compressed view, and the bytes of each.
fn size_of(compressed: &Value, limit: usize) -> Result<[usize; 2], String> {
    let (count, stride) = (number(compressed, "count")?, number(compressed, "byteStride")?);
    // A triangle has three indices.
    if count > limit.saturating_mul(3) || stride > LARGEST_ELEMENT {
        return Err(format!(
            "{count} elements of {stride} bytes are more than the limit of {limit} triangles and vertices"
        ));
    }
    Ok([count, stride])
}

fn decode_view(buffers: &[Vec<u8>], compressed: &Value, [count, stride]: [usize; 2]) -> Result<Vec<u8>, String> {
    let number = |name: &str| number(compressed, name);
    let text = |name: &str| compressed[name].as_str().unwrap_or("NONE");
    let (start, length) =
        (if compressed["byteOffset"].is_null() { 0 } else { number("byteOffset")? }, number("byteLength")?);
    let bytes = buffers.get(number("buffer")?).and_then(|buffer| buffer.get(start..start.checked_add(length)?));
    let bytes = bytes.ok_or_else(|| format!("{length} bytes from {start} are not in its buffer"))?;
    let unknown = |what: &str| format!("{what} is not known: decompress it with `gltf-transform copy IN OUT`");
    let mode = Mode::parse(text("mode")).map_err(|_| unknown(&format!("mode {}", text("mode"))))?;
    let filter = Filter::parse(text("filter")).map_err(|_| unknown(&format!("filter {}", text("filter"))))?;
    let mut workspace = Workspace::new(Limits { max_bytes: usize::MAX, ..Limits::default() });
    catch_unwind(AssertUnwindSafe(|| decode_buffer_view(mode, filter, count, stride, bytes, &mut workspace)))
        .map_err(|_| "expected meshoptimizer's bytes, found none".to_owned())?
        .map_err(|error| format!("expected meshoptimizer's bytes, found an error: {error}").replace('\n', " "))
}
