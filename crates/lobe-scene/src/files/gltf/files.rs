//! glTF containers: JSON and buffers of .gltf and .glb files, and required extensions.

use gltf_json::Root;
use serde::Deserialize;
use serde_json::Value;

use crate::SceneError;
use crate::files::source::Source;

/// The version of the attributes that Lobe writes into a baked glTF file and names in `asset.extras.lobe.version`.
/// Files with a higher one are refused.
pub const LOBE_EXTRAS_VERSION: u64 = 1;

/// JSON and buffers of a glTF file. Only the shape of the JSON has been checked.
pub(crate) struct GltfFile {
    pub(crate) root: Root,
    pub(crate) buffers: Vec<Vec<u8>>,
    /// `extras` of `asset`, null where there are none.
    pub(crate) asset_extras: Value,
}

const MAGIC: &[u8] = b"glTF";
const HEADER: usize = 12;
const CHUNK_JSON: u32 = u32::from_le_bytes(*b"JSON");
const CHUNK_BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// Required extensions that Lobe reads. Those of materials and lights are accepted and ignored: shapes and base colors
/// are the same without them, except for [`OTHER_COLORS`].
const READ_EXTENSIONS: [&str; 2] = ["KHR_texture_transform", "KHR_mesh_quantization"];

/// The extension whose materials store their colors elsewhere.
const OTHER_COLORS: &str = "KHR_materials_pbrSpecularGlossiness";

/// The parts of the JSON that decide whether the rest can be read.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Preamble {
    asset: Asset,
    #[serde(default)]
    extensions_required: Vec<String>,
    #[serde(default)]
    extensions_used: Vec<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Asset {
    version: String,
    min_version: Option<String>,
    #[serde(default)]
    extras: Value,
}

/// Reads JSON and buffers, from a .glb or from a .gltf with the files it references.
pub(crate) fn read(bytes: &[u8], source: &mut Source<'_>) -> Result<GltfFile, SceneError> {
    let (json, blob) = split(bytes, source)?;
    let preamble: Preamble = from_json(json, source)?;
    check_preamble(&preamble, source)?;
    let root: Root = from_json(json, source)?;
    let mut buffers = Vec::new();
    for (i, buffer) in root.buffers.iter().enumerate() {
        let mut data = match (&buffer.uri, blob) {
            (Some(uri), _) => read_uri(uri, source)?,
            (None, Some(blob)) if i == 0 => blob.to_vec(),
            _ => return Err(source.invalid(format!("buffer {i} has neither a URI nor a chunk of a .glb"))),
        };
        let (expected, found) = (buffer.byte_length.0, data.len());
        if (found as u64) < expected {
            return Err(source.invalid(format!("expected {expected} bytes in buffer {i}, found {found}")));
        }
        data.truncate(expected as usize);
        buffers.push(data);
    }
    Ok(GltfFile { root, buffers, asset_extras: preamble.asset.extras })
}

/// The unchecked JSON of a file with all its members.
pub(crate) fn read_json(bytes: &[u8], source: &Source<'_>) -> Result<Value, SceneError> {
    from_json(split(bytes, source)?.0, source)
}

/// The JSON and, in a .glb, the embedded buffer.
fn split<'a>(bytes: &'a [u8], source: &Source<'_>) -> Result<(&'a [u8], Option<&'a [u8]>), SceneError> {
    if bytes.starts_with(MAGIC) { split_glb(bytes, source) } else { Ok((bytes, None)) }
}

fn from_json<'a, T: Deserialize<'a>>(json: &'a [u8], source: &Source<'_>) -> Result<T, SceneError> {
    serde_json::from_slice(json).map_err(|error| source.invalid(format!("expected glTF, found an error: {error}")))
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

fn check_preamble(preamble: &Preamble, source: &mut Source<'_>) -> Result<(), SceneError> {
    let asset = &preamble.asset;
    let version = asset.min_version.as_ref().unwrap_or(&asset.version);
    let minor = version.strip_prefix("2.");
    if minor.is_none() || (asset.min_version.is_some() && minor != Some("0")) {
        return Err(source.unsupported(format!("expected version 2.0 of glTF, found {version}")));
    }
    let lobe = &asset.extras["lobe"]["version"];
    if !lobe.is_null() && lobe.as_u64().is_none_or(|version| version > LOBE_EXTRAS_VERSION) {
        return Err(source.unsupported(format!(
            "baked by a newer Lobe: expected version {LOBE_EXTRAS_VERSION} of its attributes, found {lobe}: update Lobe"
        )));
    }
    if preamble.extensions_used.iter().any(|name| name == OTHER_COLORS) {
        source.note(format!("{OTHER_COLORS} is not used, colors may be missing: convert to metallic-roughness"));
    }
    for name in &preamble.extensions_required {
        if (name.starts_with("KHR_materials_") && name != OTHER_COLORS) || name == "KHR_lights_punctual" {
            source.note(format!("{name} is not used"));
        } else if !READ_EXTENSIONS.contains(&name.as_str()) {
            return Err(source.unsupported(refusal(name)));
        }
    }
    Ok(())
}

/// The message for a file that requires an extension.
fn refusal(extension: &str) -> String {
    let advice = match extension {
        "KHR_draco_mesh_compression" => {
            "export it without Draco compression; Blender reads such a file and exports it plain by default"
        }
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => "export it without meshopt compression",
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" => "export its textures as PNG or JPEG",
        OTHER_COLORS => "convert its materials to metallic-roughness",
        "EXT_mesh_gpu_instancing" => "export each instance as a node",
        _ => "export it without",
    };
    format!("the file requires {extension}, which Lobe does not read: {advice}")
}

/// The bytes of a URI: embedded data, or a file beside the glTF file.
pub(crate) fn read_uri(uri: &str, source: &Source<'_>) -> Result<Vec<u8>, SceneError> {
    if let Some(data) = uri.strip_prefix("data:") {
        let shown: String = uri.chars().take(40).collect();
        let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
        return encoded
            .and_then(decode_base64)
            .ok_or_else(|| source.invalid(format!("expected base64 in the URI `{shown}...`")));
    }
    if uri.contains("://") {
        return Err(source.unsupported(format!("names `{uri}`: Lobe reads files only, so fetch it first")));
    }
    source.neighbor(&decode_percent(uri))
}

/// Decodes base64 (RFC 4648), padded or not; `None` if a character is not in its alphabet.
fn decode_base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for group in text.chunks(4) {
        let mut bits = 0_u32;
        for &c in group {
            let value = match c {
                b'A'..=b'Z' => c - b'A',
                b'a'..=b'z' => c - b'a' + 26,
                b'0'..=b'9' => c - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                _ => return None,
            };
            bits = bits << 6 | u32::from(value);
        }
        let whole = group.len() * 6 / 8;
        bits <<= 24 - 6 * group.len();
        bytes.extend_from_slice(&bits.to_be_bytes()[1..=whole]);
    }
    Some(bytes)
}

/// Decodes the file name of a URI: `%20` is a space.
fn decode_percent(uri: &str) -> String {
    let hex = |s: &[u8]| std::str::from_utf8(s).ok().and_then(|s| u8::from_str_radix(s, 16).ok());
    let bytes = uri.as_bytes();
    let (mut out, mut i) = (Vec::new(), 0);
    while i < bytes.len() {
        match bytes.get(i + 1..i + 3).filter(|_| bytes[i] == b'%').and_then(hex) {
            Some(byte) => {
                out.push(byte);
                i += 3;
            }
            None => {
                out.push(bytes[i]);
                i += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_and_percent_codes_are_decoded() {
        for (text, bytes) in [("", &b""[..]), ("TQ==", b"M"), ("TWE=", b"Ma"), ("TWFu", b"Man"), ("/+8", &[255, 239])] {
            assert_eq!(decode_base64(text).as_deref(), Some(bytes), "{text}");
        }
        assert_eq!(decode_base64("a b"), None, "a space is no base64");
        assert_eq!(decode_percent("my%20wood%2Fx%zz.png%"), "my wood/x%zz.png%", "percent codes");
    }
}
