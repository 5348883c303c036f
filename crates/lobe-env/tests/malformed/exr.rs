//! Malformed OpenEXR pictures, from the layout of the file.

use crate::bytes::{find, patched, replaced, words};
use crate::corpus::{self, Bad, Good};

const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

fn attribute(name: &str, kind: &str, value: &[u8]) -> Vec<u8> {
    [name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &(value.len() as u32).to_le_bytes(), value].concat()
}

/// Name, `half`, not linear, every texel.
fn channel(name: &str) -> Vec<u8> {
    [name.as_bytes(), b"\0", &words(&[1, 0, 1, 1])].concat()
}

/// The attributes of 8 x 4 texels in three `half`, without the byte 0 that ends them.
fn attributes(compression: u8) -> Vec<u8> {
    let window = words(&[0, 0, 7, 3]);
    let channels = [channel("B"), channel("G"), channel("R"), vec![0]].concat();
    [
        attribute("channels", "chlist", &channels),
        attribute("compression", "compression", &[compression]),
        attribute("dataWindow", "box2i", &window),
        attribute("displayWindow", "box2i", &window),
        attribute("lineOrder", "lineOrder", &[0]),
        attribute("pixelAspectRatio", "float", &1_f32.to_le_bytes()),
        attribute("screenWindowCenter", "v2f", &[0; 8]),
        attribute("screenWindowWidth", "float", &1_f32.to_le_bytes()),
    ]
    .concat()
}

/// Magic, version 2 with `flags`, attributes, table of offsets, then the blocks.
fn file(flags: u8, attributes: &[u8], blocks: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = [&MAGIC[..], &[2, flags, 0, 0], attributes, &[0]].concat();
    let mut offset = bytes.len() + 8 * blocks.len();
    for block in blocks {
        bytes.extend((offset as u64).to_le_bytes());
        offset += block.len();
    }
    [bytes, blocks.concat()].concat()
}

/// A block of scan lines: its first row, its bytes, then these.
fn lines(y: u32, data: &[u8]) -> Vec<u8> {
    [&words(&[y, data.len() as u32])[..], data].concat()
}

/// Eight texels of each channel, one row: 1 as `half`.
const ROW: [u8; 48] = {
    let mut row = [0; 48];
    let mut i = 1;
    while i < 48 {
        row[i] = 0x3c;
        i += 2;
    }
    row
};

fn scan_lines() -> Vec<u8> {
    file(0, &attributes(0), &[0, 1, 2, 3].map(|y| lines(y, &ROW)))
}

/// Four rows with run lengths: bytes of even and odd places apart, differences, then runs. Even bytes are 0, odd ones
/// 0x3c; a difference d is stored as d + 128.
fn rle() -> Vec<u8> {
    let runs = [0, 0x00, 22, 0x80, 0, 0xbc, 22, 0x80];
    file(0, &attributes(1), &[0, 1, 2, 3].map(|y| lines(y, &runs)))
}

/// Tiles of 4 x 4, one level.
fn tiles() -> Vec<u8> {
    let tiles = [attributes(0), attribute("tiles", "tiledesc", &[&words(&[4, 4])[..], &[0]].concat())].concat();
    let tile = |x: u32| [words(&[x, 0, 0, 0, 96]), ROW.repeat(2)].concat();
    file(2, &tiles, &[tile(0), tile(1)])
}

fn header(bytes: &[u8], blocks: usize) -> usize {
    // The table begins where its first number says that the blocks begin, less its own length.
    (0..bytes.len() - 8)
        .find(|at| bytes[*at..at + 8] == ((at + 8 * blocks) as u64).to_le_bytes())
        .unwrap_or_else(|| panic!("no table of {blocks} offsets"))
        + 8 * blocks
}

pub(crate) fn good() -> Vec<Good> {
    [("scan-lines.exr", scan_lines(), 4), ("rle.exr", rle(), 4), ("tiles.exr", tiles(), 2)]
        .map(|(name, bytes, blocks)| Good::new(name, header(&bytes, blocks), bytes))
        .into()
}

/// The scan lines with other windows: first column and row, last column and row.
fn windows(data: [i32; 4], display: [i32; 4]) -> Vec<u8> {
    let mut bytes = scan_lines();
    for (name, window) in [("dataWindow\0box2i\0", data), ("displayWindow\0box2i\0", display)] {
        let at = find(&bytes, name.as_bytes()) + name.len() + 4;
        bytes = patched(&bytes, at, &words(&window.map(|v| v as u32)));
    }
    bytes
}

fn bad_headers() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let good = scan_lines();
    // The offset of an attribute's value.
    let value =
        |name: &str, kind: &str| find(&good, format!("{name}\0{kind}\0").as_bytes()) + name.len() + kind.len() + 6;
    let list = value("channels", "chlist");
    let without = |name: &str, kind: &str, length: usize| {
        let end = value(name, kind) + length;
        let start = find(&good, format!("{name}\0{kind}\0").as_bytes());
        [&good[..start], &good[end..]].concat()
    };
    vec![
        ("magic", "the fourth byte is 2", patched(&good, 3, &[2])),
        ("version", "version 3", patched(&good, 4, &[3])),
        ("flags", "all flags of the version are set", patched(&good, 5, &[255, 255, 255])),
        ("deep", "deep data", patched(&good, 5, &[8])),
        ("multi-part", "said to have parts, which it has not", patched(&good, 5, &[0x10])),
        ("cut-version", "cut within the version", good[..6].into()),
        ("cut-attribute", "cut within an attribute", good[..list + 20].into()),
        (
            "cut-attributes",
            "cut before the end of the attributes",
            good[..value("screenWindowWidth", "float") + 4].into(),
        ),
        ("name-long", "the name of an attribute has no end", [&good[..8], &b"a".repeat(300)].concat()),
        ("attribute-long", "an attribute of 4 GiB", patched(&good, list - 4, &[255; 4])),
        ("attribute-half", "an attribute of 2 GiB", patched(&good, list - 4, &[255, 255, 255, 127])),
        ("attribute-short", "the list of channels has 3 bytes", patched(&good, list - 4, &[3, 0, 0, 0])),
        ("no-channels", "no list of channels", without("channels", "chlist", 55)),
        ("no-data-window", "no data window", without("dataWindow", "box2i", 16)),
        ("no-compression", "no compression", without("compression", "compression", 1)),
        ("channel-type", "a channel of type 9", patched(&good, list + 2, &[9])),
        (
            "channel-integer",
            "channels of integers",
            replaced(
                &replaced(
                    &replaced(&good, &channel("R"), b"R\0\0\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0"),
                    &channel("G"),
                    b"G\0\0\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0",
                ),
                &channel("B"),
                b"B\0\0\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0",
            ),
        ),
        ("channel-sampling", "a channel sampled every 0 texels", patched(&good, list + 10, &[0])),
        ("channel-twice", "two channels of one name", patched(&good, list + 18, b"B")),
        (
            "channels-others",
            "channels X, Y2 and Z",
            patched(&patched(&patched(&good, list, b"X"), list + 18, b"T"), list + 36, b"Z"),
        ),
        ("compression-unknown", "compression 99", patched(&good, value("compression", "compression"), &[99])),
        ("line-order", "line order 7", patched(&good, value("lineOrder", "lineOrder"), &[7])),
    ]
}

fn bad_windows() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let small = [0, 0, 7, 3];
    vec![
        ("size-absurd", "100000 x 50000", windows([0, 0, 99_999, 49_999], [0, 0, 99_999, 49_999])),
        ("size-promise", "16000 x 8000 texels in 192 bytes", windows([0, 0, 15_999, 7999], [0, 0, 15_999, 7999])),
        ("rows-promise", "a data window of 16711684 rows in 192 bytes", windows([0, 0, 7, 0xff_0003], small)),
        (
            "display-promise",
            "a display window of 16000 x 8000 around 8 x 4 texels",
            windows(small, [0, 0, 15_999, 7999]),
        ),
        ("size-square", "8 x 8", windows(small, [0, 0, 7, 7])),
        ("window-empty", "a display window of no columns", windows(small, [0, 0, -1, 3])),
        ("window-turned", "a data window whose end lies before its beginning", windows([7, 3, 0, 0], small)),
        ("window-wide", "a data window of 2^31 columns", windows([0, 0, i32::MAX, 3], small)),
        (
            "window-extreme",
            "windows from the least to the greatest number",
            windows([i32::MIN, i32::MIN, i32::MAX, i32::MAX], [i32::MIN, i32::MIN, i32::MAX, i32::MAX]),
        ),
        (
            "window-far",
            "a data window at the end of the numbers",
            windows([i32::MAX, i32::MAX, i32::MAX, i32::MAX], small),
        ),
    ]
}

fn bad_blocks() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let (good, rle, tiles) = (scan_lines(), rle(), tiles());
    let blocks = header(&good, 4);
    let table = blocks - 32;
    let tile_size = find(&tiles, b"tiledesc\0") + 13;
    let tile_blocks = header(&tiles, 2);
    let rle_blocks = header(&rle, 4);
    let mut twice = good.clone();
    twice.copy_within(table..table + 8, table + 8);
    let compressed = |compression: u8, data: &[u8]| file(0, &attributes(compression), &[lines(0, data)]);
    // Eleven numbers: version, sizes of the sections when inflated and stored, and the choice of the coder.
    let dwa: Vec<u8> =
        [2, 1 << 60, 8, 1 << 60, 8, 1 << 60, 1 << 60, 8, 1 << 60, 1 << 60, 1].map(u64::to_le_bytes).concat();
    vec![
        ("cut-table", "cut within the table of offsets", good[..table + 12].into()),
        ("cut-blocks", "cut before the first block", good[..blocks].into()),
        ("cut-block", "cut within the second block", good[..blocks + 80].into()),
        ("cut-last", "cut before the last byte", good[..good.len() - 1].into()),
        ("table-zero", "a table of zeros, as of an unfinished file", patched(&good, table, &[0; 32])),
        ("table-outside", "an offset behind the end", patched(&good, table, &(1_u64 << 40).to_le_bytes())),
        ("table-negative", "an offset of 2^64 - 1", patched(&good, table, &[255; 8])),
        ("table-twice", "two offsets of one block", twice),
        ("block-row", "a block of row 77", patched(&good, blocks, &[77])),
        ("block-row-negative", "a block of row -2^31", patched(&good, blocks, &[0, 0, 0, 128])),
        ("block-long", "a block of 2 GiB", patched(&good, blocks + 4, &[255, 255, 255, 127])),
        ("block-negative", "a block of -1 bytes", patched(&good, blocks + 4, &[255; 4])),
        ("block-empty", "a block of no bytes", patched(&good, blocks + 4, &[0; 4])),
        ("rle-long", "a run that reaches beyond the block", patched(&rle, rle_blocks + 8, &[127, 0])),
        ("rle-cut", "bytes that are announced and missing", patched(&rle, rle_blocks + 16, &[0x81])),
        ("zip-damaged", "a block that is no zlib", compressed(3, &[0xff; 40])),
        ("zip-empty", "a block of zlib that holds nothing", compressed(3, &[0x78, 1, 1, 0, 0, 255, 255, 0, 0, 0, 1])),
        ("piz-damaged", "damaged PIZ", compressed(4, &[0xff; 40])),
        ("piz-zero", "PIZ of zeros", compressed(4, &[0; 40])),
        ("pxr24-damaged", "damaged PXR24", compressed(5, &[0xff; 40])),
        ("b44-damaged", "damaged B44", compressed(6, &[0xff; 40])),
        ("dwaa-damaged", "damaged DWAA", compressed(8, &[0xff; 100])),
        ("dwaa-sizes", "DWAA whose sections take 2^60 bytes", compressed(8, &dwa)),
        ("dwab-short", "DWAB without its sizes", compressed(9, &[0; 40])),
        ("tile-zero", "tiles of 0 x 0", patched(&tiles, tile_size, &[0; 8])),
        ("tile-huge", "tiles of 2^32 - 1", patched(&tiles, tile_size, &[255; 8])),
        ("tile-mode", "tiles in levels of unknown kind", patched(&tiles, tile_size + 8, &[0x7f])),
        ("tile-place", "a tile in column 900", patched(&tiles, tile_blocks, &words(&[900]))),
        ("tile-level", "a tile of level 5", patched(&tiles, tile_blocks + 8, &words(&[5, 5]))),
        ("tile-short", "a tile of one byte", patched(&tiles, tile_blocks + 16, &words(&[1]))),
        ("tile-cut", "cut before the last byte", tiles[..tiles.len() - 1].into()),
        ("nan", "a texel is NaN", patched(&good, blocks + 8, &[0, 0x7e])),
    ]
}

pub(crate) fn bad() -> Vec<Bad> {
    corpus::bad("exr", [bad_headers(), bad_windows(), bad_blocks()].concat())
}
