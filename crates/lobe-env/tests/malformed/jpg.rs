//! Malformed JPEG pictures. Their tables take some hundred bytes, so the valid one is kept as an encoder wrote it.

use crate::bytes::{find, patched};
use crate::corpus::{self, Bad, Good};

/// 16 x 8 texels in three colors.
fn small() -> Vec<u8> {
    include_bytes!("../corpus/good/small.jpg").to_vec()
}

/// The offset of the segment with this marker.
fn segment(bytes: &[u8], mark: u8) -> usize {
    find(bytes, &[0xff, mark])
}

const QUANTIZATION: u8 = 0xdb;
const FRAME: u8 = 0xc0;
const HUFFMAN: u8 = 0xc4;
const SCAN: u8 = 0xda;

pub(crate) fn good() -> Vec<Good> {
    let small = small();
    let scan = segment(&small, SCAN);
    let header = scan + 2 + usize::from(small[scan + 3]);
    vec![Good::new("small.jpg", header, small)]
}

/// A frame says: mark, length, bits, rows, columns, colors.
fn with_size(rows: u16, columns: u16) -> Vec<u8> {
    let small = small();
    let size = [rows.to_be_bytes(), columns.to_be_bytes()].concat();
    patched(&small, segment(&small, FRAME) + 5, &size)
}

/// The picture without its last bytes, behind a segment of a camera's notes that holds the whole picture.
fn cut_behind_thumbnail(small: &[u8]) -> Vec<u8> {
    let length = (small.len() + 8) as u16;
    let notes = [&[0xff, 0xe1], &length.to_be_bytes()[..], b"Exif\0\0", small].concat();
    [&small[..2], &notes, &small[2..small.len() - 20]].concat()
}

pub(crate) fn bad() -> Vec<Bad> {
    let small = small();
    let at = |mark: u8| segment(&small, mark);
    let cut = |length: usize| small[..length].to_vec();
    // The end stands behind what is missing, so that it is not the only thing that is noticed.
    let cut_and_ended = |length: usize| [&small[..length], &[0xff, 0xd9]].concat();
    let scan_data = good()[0].header;
    let files = vec![
        ("cut-signature", "cut after the mark of the beginning", cut(3)),
        ("cut-tables", "cut within the first table", cut(at(QUANTIZATION) + 30)),
        ("cut-frame", "cut within the size", cut(at(FRAME) + 6)),
        ("cut-scan", "cut before the first texel", cut(scan_data)),
        ("cut-last", "cut before the mark of the end", cut(small.len() - 2)),
        ("ends-at-once", "the beginning and the end", vec![0xff, 0xd8, 0xff, 0xd9]),
        ("ends-in-tables", "the end stands within the first table", cut_and_ended(at(QUANTIZATION) + 30)),
        ("ends-in-frame", "the end stands within the size", cut_and_ended(at(FRAME) + 6)),
        ("ends-before-scan", "the end stands in place of the scan", cut_and_ended(at(SCAN))),
        ("ends-in-scan", "the end stands within the scan", cut_and_ended(scan_data + (small.len() - scan_data) / 2)),
        (
            "cut-thumbnail",
            "cut within the scan, behind a thumbnail with an end of its own",
            cut_behind_thumbnail(&small),
        ),
        ("no-frame", "no frame", [&small[..at(FRAME)], &small[at(HUFFMAN)..]].concat()),
        ("no-huffman", "no Huffman table", [&small[..at(HUFFMAN)], &small[at(SCAN)..]].concat()),
        ("size-zero", "0 columns", with_size(8, 0)),
        ("size-none", "0 rows", with_size(0, 16)),
        ("size-absurd", "65500 x 32750", with_size(32_750, 65_500)),
        ("size-promise", "16000 x 8000 texels in some hundred bytes", with_size(8000, 16_000)),
        ("size-square", "16 x 16", with_size(16, 16)),
        ("bits", "13 bits", patched(&small, at(FRAME) + 4, &[13])),
        ("arithmetic", "arithmetic coding", patched(&small, at(FRAME) + 1, &[0xc9])),
        ("lossless", "the lossless kind", patched(&small, at(FRAME) + 1, &[0xc3])),
        ("sampling", "a color sampled 0 times", patched(&small, at(FRAME) + 11, &[0])),
        ("table-missing", "a color names a table that is not there", patched(&small, at(FRAME) + 12, &[3])),
        ("segment-length", "a segment of length 0", patched(&small, at(QUANTIZATION) + 2, &[0, 0])),
        ("segment-long", "a segment longer than the file", patched(&small, at(QUANTIZATION) + 2, &[255, 255])),
        ("huffman", "a Huffman table of too many codes", patched(&small, at(HUFFMAN) + 5, &[255; 16])),
    ];
    corpus::bad("jpg", files)
}
