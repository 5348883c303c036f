//! Builders of malformed bytes.

/// `bytes` with `value` written at the offset `at`.
pub(crate) fn patched(bytes: &[u8], at: usize, value: &[u8]) -> Vec<u8> {
    let mut patched = bytes.to_vec();
    patched[at..at + value.len()].copy_from_slice(value);
    patched
}

/// `bytes` with the first `from` replaced by `to`, of any length.
pub(crate) fn replaced(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let at = find(bytes, from);
    [&bytes[..at], to, &bytes[at + from.len()..]].concat()
}

/// The offset of `what` in `bytes`.
pub(crate) fn find(bytes: &[u8], what: &[u8]) -> usize {
    bytes.windows(what.len()).position(|w| w == what).unwrap_or_else(|| panic!("{what:02x?} is not there"))
}

/// 32-bit numbers, the lowest byte first.
pub(crate) fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
