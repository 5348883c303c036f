//! Malformed PNG pictures.

use crate::bytes::patched;
use crate::corpus::{self, Bad, Good};

const MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";

/// The remainder that ends a chunk: CRC-32, bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| step(crc)))
}

fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [kind.as_slice(), data].concat();
    [&(data.len() as u32).to_be_bytes()[..], &body, &crc(&body).to_be_bytes()].concat()
}

/// Width, height, bits, color type; nothing special about compression, filter and rows.
fn ihdr(width: u32, height: u32, bits: u8, color: u8) -> Vec<u8> {
    chunk(b"IHDR", &[&width.to_be_bytes()[..], &height.to_be_bytes(), &[bits, color, 0, 0, 0]].concat())
}

/// A zlib stream that stores `data` as it is, ending in Adler's sums.
fn stored(data: &[u8]) -> Vec<u8> {
    let (a, b) = data.iter().fold((1u32, 0u32), |(a, b), byte| {
        let a = (a + u32::from(*byte)) % 65521;
        (a, (b + a) % 65521)
    });
    let length = data.len() as u16;
    [&[0x78, 0x01, 0x01][..], &length.to_le_bytes(), &(!length).to_le_bytes(), data, &(b << 16 | a).to_be_bytes()]
        .concat()
}

/// 8 x 4 texels in RGB of 8 bits, each row after its filter byte.
fn rows() -> Vec<u8> {
    (0..4).flat_map(|y| [vec![0], (0..24).map(|x| 10 * x + y).collect()].concat()).collect()
}

fn file(chunks: &[Vec<u8>]) -> Vec<u8> {
    [MAGIC, &chunks.concat()].concat()
}

fn small() -> Vec<u8> {
    file(&[ihdr(8, 4, 8, 2), chunk(b"IDAT", &stored(&rows())), chunk(b"IEND", &[])])
}

/// Signature, `IHDR`, the head of `IDAT` and of its stream.
const HEADER: usize = 8 + 25 + 8 + 7;

pub(crate) fn good() -> Vec<Good> {
    let gray: Vec<u8> = (0..4).flat_map(|y| [vec![1], vec![y; 16]].concat()).collect();
    let gray = file(&[ihdr(8, 4, 16, 0), chunk(b"IDAT", &stored(&gray)), chunk(b"IEND", &[])]);
    vec![Good::new("small.png", HEADER, small()), Good::new("gray-16.png", HEADER, gray)]
}

pub(crate) fn bad() -> Vec<Bad> {
    let small = small();
    let (data, end) = (chunk(b"IDAT", &stored(&rows())), chunk(b"IEND", &[]));
    let with = |head: Vec<u8>| file(&[head, data.clone(), end.clone()]);
    let with_data = |data: &[u8]| file(&[ihdr(8, 4, 8, 2), chunk(b"IDAT", data), end.clone()]);
    let mut odd = ihdr(8, 4, 8, 2);
    odd.truncate(21);
    let bad_method = |at: usize| {
        let head = patched(&ihdr(8, 4, 8, 2)[4..21], 4 + at, &[9]);
        with(chunk(b"IHDR", &head[4..]))
    };
    let files = vec![
        ("magic", "a line end of the signature was converted", patched(&small, 4, b"\n\n")),
        ("cut-signature", "cut after the signature", small[..8].into()),
        ("cut-head", "cut within IHDR", small[..20].into()),
        ("cut-head-end", "cut after IHDR", small[..33].into()),
        ("cut-data-head", "cut after the head of IDAT", small[..41].into()),
        ("cut-data", "cut within IDAT", small[..80].into()),
        ("no-head", "no IHDR", file(&[data.clone(), end.clone()])),
        ("no-data", "no IDAT", file(&[ihdr(8, 4, 8, 2), end.clone()])),
        ("crc", "the checksum of IHDR is wrong", patched(&small, 29, &[0; 4])),
        ("chunk-length", "IHDR says that it has 4294967295 bytes", patched(&small, 8, &[255; 4])),
        ("data-length", "IDAT says that it has 2147483647 bytes", patched(&small, 33, &[127, 255, 255, 255])),
        ("size-zero", "0 columns", with(ihdr(0, 4, 8, 2))),
        ("size-absurd", "100000 x 50000", with(ihdr(100_000, 50_000, 8, 2))),
        ("size-overflow", "sides of 2^31 - 1", with(ihdr(i32::MAX as u32, i32::MAX as u32, 16, 6))),
        ("size-promise", "16000 x 8000 texels in 190 bytes", with(ihdr(16_000, 8000, 8, 2))),
        ("size-more", "16 x 8 texels, of which the data has a quarter", with(ihdr(16, 8, 8, 2))),
        ("size-square", "4 x 4", with(ihdr(4, 4, 8, 2))),
        ("bits", "3 bits", with(ihdr(8, 4, 3, 2))),
        ("color-type", "color type 5", with(ihdr(8, 4, 8, 5))),
        ("compression", "compression method 9", bad_method(10)),
        ("interlace", "interlace method 9", bad_method(12)),
        ("palette", "indices without a palette", with(ihdr(8, 4, 8, 3))),
        ("zlib-head", "the stream is no zlib", with_data(&patched(&stored(&rows()), 0, &[0xff]))),
        ("zlib-block", "a block of unknown type", with_data(&patched(&stored(&rows()), 2, &[0x07]))),
        ("zlib-length", "a stored block whose two lengths disagree", with_data(&patched(&stored(&rows()), 3, &[0]))),
        ("zlib-short", "the stream ends before the last row", with_data(&stored(&rows()[..60]))),
        ("filter", "a row of filter 9", with_data(&stored(&patched(&rows(), 25, &[9])))),
    ];
    corpus::bad("png", files)
}
