//! Containers of glTF: the JSON and the embedded buffer of .gltf and .glb files.

use crate::SceneError;
use crate::files::source::Source;

const MAGIC: &[u8] = b"glTF";
const HEADER: usize = 12;
const CHUNK_JSON: u32 = u32::from_le_bytes(*b"JSON");
const CHUNK_BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// The JSON and, in a .glb, the embedded buffer.
pub(crate) fn split<'a>(bytes: &'a [u8], source: &Source<'_>) -> Result<(&'a [u8], Option<&'a [u8]>), SceneError> {
    if bytes.starts_with(MAGIC) { split_glb(bytes, source) } else { Ok((bytes, None)) }
}

/// The chunks of a .glb.
fn split_glb<'a>(bytes: &'a [u8], source: &Source<'_>) -> Result<(&'a [u8], Option<&'a [u8]>), SceneError> {
    let word = |at: usize| bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let cut_off = || source.invalid(format!("a .glb that is cut off after {} bytes", bytes.len()));
    match word(4).ok_or_else(cut_off)? {
        2 => {}
        version => return Err(source.unsupported(format!("expected version 2 of glTF, found {version}"))),
    }
    let chunk = |at: usize| -> Result<(u32, &'a [u8]), SceneError> {
        let (length, kind) = (word(at).ok_or_else(cut_off)? as usize, word(at + 4).ok_or_else(cut_off)?);
        let data = bytes.get(at + 8..).and_then(|rest| rest.get(..length)).ok_or_else(cut_off)?;
        Ok((kind, data))
    };
    let (kind, json) = chunk(HEADER)?;
    if kind != CHUNK_JSON {
        return Err(source.invalid("expected a first chunk of JSON in the .glb, found another"));
    }
    let next = HEADER + 8 + json.len().next_multiple_of(4);
    let blob = if next + 8 <= bytes.len() { Some(chunk(next)?) } else { None };
    Ok((json, blob.filter(|&(kind, _)| kind == CHUNK_BIN).map(|(_, data)| data)))
}
