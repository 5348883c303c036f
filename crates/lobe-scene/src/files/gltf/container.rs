//! Containers of glTF: the JSON and the embedded buffer of .gltf and .glb files.

use std::ops::Range;

use crate::error::SceneError;
use crate::files::source::Source;

const MAGIC: &[u8] = b"glTF";
/// What some editors write in front of text in UTF-8; it says nothing.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";
const HEADER: usize = 12;
const CHUNK_JSON: u32 = u32::from_le_bytes(*b"JSON");
const CHUNK_BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// Where the JSON is and, in a .glb, the embedded buffer.
type Parts = (Range<usize>, Option<Range<usize>>);

/// The JSON and, in a .glb, the embedded buffer.
pub(crate) fn split(bytes: &[u8], source: &Source<'_>) -> Result<Parts, SceneError> {
    let (mut json, blob) = if bytes.starts_with(MAGIC) { split_glb(bytes, source)? } else { (0..bytes.len(), None) };
    if bytes[json.clone()].starts_with(BYTE_ORDER_MARK) {
        json.start += BYTE_ORDER_MARK.len();
    }
    Ok((json, blob))
}

/// The chunks of a .glb.
fn split_glb(bytes: &[u8], source: &Source<'_>) -> Result<Parts, SceneError> {
    let word = |at: usize| bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let cut_off = || source.invalid(format!("a .glb that is cut off after {} bytes", bytes.len()));
    match word(4).ok_or_else(cut_off)? {
        2 => {}
        version => return Err(source.unsupported(format!("expected version 2 of glTF, found {version}"))),
    }
    let chunk = |at: usize| -> Result<(u32, Range<usize>), SceneError> {
        let (length, kind) = (word(at).ok_or_else(cut_off)? as usize, word(at + 4).ok_or_else(cut_off)?);
        let end = (at + 8).checked_add(length).filter(|&end| end <= bytes.len()).ok_or_else(cut_off)?;
        Ok((kind, at + 8..end))
    };
    let (kind, json) = chunk(HEADER)?;
    if kind != CHUNK_JSON {
        return Err(source.invalid("expected a first chunk of JSON in the .glb, found another"));
    }
    let next = HEADER + 8 + json.len().next_multiple_of(4);
    let blob = if next + 8 <= bytes.len() { Some(chunk(next)?) } else { None };
    Ok((json, blob.filter(|&(kind, _)| kind == CHUNK_BIN).map(|(_, range)| range)))
}
