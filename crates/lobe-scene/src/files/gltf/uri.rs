//! URIs of glTF files: embedded data, and files.

use crate::error::SceneError;
use crate::files::source::Source;

/// The bytes of a URI: embedded data, or a file beside the glTF file.
pub(crate) fn read_uri(uri: &str, source: &mut Source<'_>) -> Result<Vec<u8>, SceneError> {
    if let Some(data) = uri.strip_prefix("data:") {
        source.count_bytes(data.len() as u64 / 4 * 3)?;
        let shown: String = uri.chars().take(40).collect();
        let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
        return encoded
            .and_then(decode_base64)
            .ok_or_else(|| source.invalid(format!("expected base64 in the URI `{shown}...`")));
    }
    if uri.contains("://") {
        return Err(source.unsupported(format!("names `{uri}`: Lobe reads files only, so fetch it first")));
    }
    source.referenced_file(&decode_percent(uri))
}

/// Decodes base64 (RFC 4648), padded or not; `None` if a character is not in its alphabet.
fn decode_base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for group in text.chunks(4) {
        // Six bits are no byte.
        if group.len() == 1 {
            return None;
        }
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
    let hex = |s: &[u8]| {
        let digits = std::str::from_utf8(s).ok().filter(|s| s.bytes().all(|c| c.is_ascii_hexdigit()));
        digits.and_then(|s| u8::from_str_radix(s, 16).ok())
    };
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
        assert_eq!(decode_base64("TWFuA"), None, "a rest of one character is no byte");
        assert_eq!(decode_percent("my%20wood%2Fx%zz%+5.png%"), "my wood/x%zz%+5.png%", "percent codes");
    }
}
