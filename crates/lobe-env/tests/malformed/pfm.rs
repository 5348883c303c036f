//! Malformed portable float maps.

use crate::bytes::{patched, replaced};
use crate::corpus::{self, Bad, Good};

const HEADER: &[u8] = b"PF\n4 2\n-1.0\n";

fn color() -> Vec<u8> {
    [HEADER, &1.5_f32.to_le_bytes().repeat(24)].concat()
}

pub(crate) fn good() -> Vec<Good> {
    let gray = [&b"Pf 4 2 1 "[..], &1.5_f32.to_be_bytes().repeat(8)].concat();
    vec![Good::new("color.pfm", HEADER.len(), color()), Good::new("gray.pfm", 9, gray)]
}

pub(crate) fn bad() -> Vec<Bad> {
    let color = color();
    let size = |to: &str| replaced(&color, b"4 2", to.as_bytes());
    let scale = |to: &str| replaced(&color, b"-1.0", to.as_bytes());
    let files = vec![
        ("magic", "the first two bytes are `PX`", patched(&color, 1, b"X")),
        ("cut-signature", "cut after `PF`", color[..2].into()),
        ("cut-width", "cut after the number of columns", color[..4].into()),
        ("cut-height", "cut after the number of rows", color[..6].into()),
        ("cut-scale", "cut after the scale", color[..HEADER.len() - 1].into()),
        ("cut-pixels", "cut after the header", color[..HEADER.len()].into()),
        ("cut-last", "cut before the last byte", color[..color.len() - 1].into()),
        ("size-zero", "0 columns", size("0 2")),
        ("size-negative", "-4 columns", size("-4 2")),
        ("size-fraction", "4.0 columns", size("4.0 2")),
        ("size-absurd", "100000 x 50000", size("100000 50000")),
        ("size-overflow", "sides of 2^63, whose product overflows", size("9223372036854775808 9223372036854775808")),
        ("size-endless", "a side of 300 digits", size(&format!("{} 2", "9".repeat(300)))),
        ("size-promise", "16000 x 8000 texels in 96 bytes", size("16000 8000")),
        ("size-square", "2 x 2", size("2 2")),
        ("scale-zero", "a scale of 0", scale("0")),
        ("scale-nan", "a scale that is no number", scale("nan")),
        ("scale-infinite", "an infinite scale", scale("-inf")),
        ("scale-word", "a word in place of the scale", scale("little")),
        ("scale-huge", "values times the scale overflow", scale("-3e38")),
        ("nan", "a texel is NaN", patched(&color, HEADER.len() + 12, &f32::NAN.to_le_bytes())),
        ("infinite", "a texel is infinite", patched(&color, HEADER.len() + 12, &f32::INFINITY.to_le_bytes())),
        ("blanks", "nothing but white space after the signature", [&b"PF"[..], &b" ".repeat(400)].concat()),
    ];
    corpus::bad("pfm", files)
}
