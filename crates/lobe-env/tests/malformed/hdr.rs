//! Malformed Radiance pictures.

use crate::bytes::{find, patched, replaced};
use crate::corpus::{self, Bad, Good};

const HEADER: &[u8] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n";

/// 8 x 4 texels, flat: the first byte of no row is 2, which would announce the new encoding.
fn flat() -> Vec<u8> {
    [HEADER, &[128, 64, 32, 129].repeat(32)].concat()
}

/// The same in the new run-length encoding: each row is a mark, then four planes.
fn runs() -> Vec<u8> {
    let row = [&[2, 2, 0, 8][..], &[128 + 8, 128, 128 + 8, 64, 128 + 8, 32, 4, 129, 129, 129, 129, 128 + 4, 129]];
    [HEADER, &row.concat().repeat(4)].concat()
}

/// The same in the old encoding: a texel, then a repeat count.
fn repeats() -> Vec<u8> {
    [HEADER, &[128, 64, 32, 129, 1, 1, 1, 7].repeat(4)].concat()
}

pub(crate) fn good() -> Vec<Good> {
    let upright = [("flat.hdr", flat()), ("runs.hdr", runs()), ("repeats.hdr", repeats())];
    let mut files: Vec<Good> = upright.map(|(name, bytes)| Good::new(name, HEADER.len(), bytes)).into();
    let header = b"#?RADIANCE\n\tEXPOSURE=9\nFORMAT=32-bit_rle_xyze\n\n-X 8 +Y 4\n";
    files.push(Good::new("columns-xyze.hdr", header.len(), [&header[..], &flat()[HEADER.len()..]].concat()));
    files
}

pub(crate) fn bad() -> Vec<Bad> {
    let (flat, runs, repeats) = (flat(), runs(), repeats());
    let size = |to: &str| replaced(&flat, b"-Y 4 +X 8", to.as_bytes());
    let line = |line: &str| replaced(&flat, b"FORMAT=32-bit_rle_rgbe", line.as_bytes());
    let pixels = HEADER.len();
    let files = vec![
        ("empty", "no bytes", Vec::new()),
        ("magic", "the first two bytes are `#!`", patched(&flat, 1, b"!")),
        ("cut-signature", "cut after `#?`", flat[..2].into()),
        ("cut-header", "cut within the lines of the header", flat[..20].into()),
        ("cut-empty-line", "cut after the empty line", flat[..find(&flat, b"-Y")].into()),
        ("cut-size", "cut within the line of the size", flat[..pixels - 3].into()),
        ("cut-pixels", "cut after the header", flat[..pixels].into()),
        ("cut-flat", "cut before the last byte", flat[..flat.len() - 1].into()),
        ("cut-runs", "cut within the last run", runs[..runs.len() - 1].into()),
        ("cut-repeats", "cut within the last repeat count", repeats[..repeats.len() - 1].into()),
        ("size-zero", "0 columns", size("-Y 4 +X 0")),
        ("size-negative", "-4 rows", size("-Y -4 +X 8")),
        ("size-word", "a word in place of a number", size("-Y four +X 8")),
        ("size-missing", "one side only", size("-Y 4")),
        ("size-absurd", "100000 x 50000", size("-Y 50000 +X 100000")),
        ("size-overflow", "sides of 2^32 - 1, whose product overflows", size("-Y 4294967295 +X 4294967295")),
        ("size-endless", "a side of 40 digits", size(&format!("-Y {} +X 8", "9".repeat(40)))),
        ("size-promise", "8192 x 4096 texels in 128 bytes", size("-Y 4096 +X 8192")),
        ("size-square", "8 x 8", size("-Y 8 +X 8")),
        ("axes", "two axes of which one is twice", size("-Y 4 +Y 8")),
        ("floats", "texels that are floats", line("FORMAT=float")),
        ("exposure-nan", "an exposure that is no number", line("EXPOSURE=NaN")),
        ("exposure-tiny", "an exposure whose inverse is infinite", line("EXPOSURE=1e-44")),
        ("text", "a header without end", [&b"#?RADIANCE\n"[..], &b"A=B\n".repeat(100)].concat()),
        ("run-width", "the mark of a row gives another width", patched(&runs, pixels + 3, &[9])),
        ("run-long", "a run reaches beyond the row", patched(&runs, pixels + 4, &[255])),
        ("run-empty", "runs of length 0 without end", patched(&runs, pixels + 4, &[0; 40])),
        ("repeat-first", "a repeat count before any texel", patched(&repeats, pixels, &[1, 1, 1, 7])),
        ("repeat-long", "a repeat count reaches beyond the row", patched(&repeats, pixels + 7, &[200])),
    ];
    corpus::bad("hdr", files)
}
