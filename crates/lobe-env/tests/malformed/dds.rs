//! Malformed DDS cube maps.

use crate::bytes::{patched, words};
use crate::corpus::{self, Bad, Good};

/// Faces of 2 x 2 and 1 x 1 texels in RGBA16F, with the header of Direct3D 10.
fn new() -> Vec<u8> {
    let mut header = vec![0; 31];
    for (at, value) in [(0, 124), (1, 0x2_100f), (2, 2), (3, 2), (4, 16), (6, 2), (18, 32), (19, 4)] {
        header[at] = value;
    }
    header[20] = u32::from_le_bytes(*b"DX10");
    (header[26], header[27]) = (0x40_1008, 0xfe00);
    let second = [10, 3, 4, 1, 3];
    let face = [0, 0x3c, 0, 0x40, 0, 0x38, 0, 0x3c].repeat(5);
    [&b"DDS "[..], &words(&header), &words(&second), &face.repeat(6)].concat()
}

/// The same without the second header: the format as the number of Direct3D 9.
fn old() -> Vec<u8> {
    let new = new();
    patched(&[&new[..HEADER], &new[HEADER_DX10..]].concat(), 84, &words(&[113]))
}

const HEADER: usize = 128;
const HEADER_DX10: usize = 148;

pub(crate) fn good() -> Vec<Good> {
    vec![Good::new("new.dds", HEADER_DX10, new()), Good::new("old.dds", HEADER, old())]
}

pub(crate) fn bad() -> Vec<Bad> {
    let (new, old) = (new(), old());
    let word = |at: usize, value: u32| patched(&new, at, &value.to_le_bytes());
    let size = |size: u32| patched(&new, 12, &words(&[size, size]));
    let files = vec![
        ("magic", "the first four bytes are `DDS.`", patched(&new, 3, b".")),
        ("cut-magic", "cut after the first four bytes", new[..4].into()),
        ("cut-header", "cut within the first header", new[..80].into()),
        ("cut-second", "cut after the first header", new[..HEADER].into()),
        ("cut-faces", "cut after the second header", new[..HEADER_DX10].into()),
        ("cut-last", "cut before the last byte", new[..new.len() - 1].into()),
        ("header-size", "a header of 100 bytes", word(4, 100)),
        ("format-size", "a format of 0 bytes", word(76, 0)),
        ("size-zero", "faces of 0 x 0", size(0)),
        ("size-absurd", "faces of 100000 x 100000", size(100_000)),
        ("size-overflow", "faces of 2^32 - 1", size(u32::MAX)),
        ("size-promise", "faces of 4096 x 4096 in 240 bytes", size(4096)),
        ("not-square", "faces of 2 x 4", word(12, 4)),
        ("levels-many", "3 levels of faces of 2 x 2", word(28, 3)),
        ("levels-absurd", "2^32 - 1 levels", word(28, u32::MAX)),
        ("letters", "the format DXT5", patched(&new, 84, b"DXT5")),
        ("letters-unknown", "a format of bytes that are no letters", patched(&new, 84, &[0xff; 4])),
        ("format-bytes", "RGBA in 8 bits", word(128, 28)),
        ("format-unknown", "the DXGI format 4294967295", word(128, u32::MAX)),
        ("no-cube", "a picture, not a cube", patched(&word(136, 0), 112, &words(&[0]))),
        ("array-none", "an array of 0", word(140, 0)),
        ("array", "an array of 5", word(140, 5)),
        ("old-faces", "one face of six", patched(&old, 112, &words(&[0x600]))),
        ("old-cut", "cut before the last byte", old[..old.len() - 1].into()),
        ("infinite", "a texel is infinite", patched(&new, HEADER_DX10, &[0, 0x7c])),
    ];
    corpus::bad("dds", files)
}
