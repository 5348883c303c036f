//! Malformed KTX2 cube maps, from the specification.

use crate::bytes::{patched, words};
use crate::corpus::{self, Bad, Good};

const IDENTIFIER: &[u8; 12] = b"\xabKTX 20\xbb\r\n\x1a\n";

/// `VK_FORMAT_R16G16B16A16_SFLOAT`.
const RGBA16F: u32 = 97;

/// The descriptor of four `half`: total size; head; model, primaries, transfer function; plane; then the samples.
fn descriptor() -> Vec<u8> {
    let head = [92, 0, 88 << 16 | 2, 0x0001_0101, 0, 8, 0];
    let sample = |i: u32, channel: u32| [(channel | 0xc0) << 24 | 15 << 16 | (16 * i), 0, 0xbf80_0000, 0x3f80_0000];
    let samples: Vec<u32> = [0, 1, 2, 15].into_iter().enumerate().flat_map(|(i, c)| sample(i as u32, c)).collect();
    words(&[&head[..], &samples].concat())
}

const KEYS: &[u8] = b"\x12\0\0\0KTXorientation\0rd\0\0\0";

/// The level index begins behind the header; the descriptor follows two levels.
const INDEX: usize = 80;
const DESCRIPTOR: usize = INDEX + 2 * 24;

/// A level, and how many bytes it stands for.
struct Level {
    stored: Vec<u8>,
    raw: u64,
}

/// A cube map of faces of `size`, with two levels, the largest first.
fn file(size: u32, scheme: u32, levels: [Level; 2]) -> Vec<u8> {
    let descriptor = descriptor();
    let keys = DESCRIPTOR + descriptor.len();
    let [large, small] = levels;
    let data = (keys + KEYS.len()).next_multiple_of(8);
    let places = [(data + small.stored.len(), &large), (data, &small)];
    let mut bytes = IDENTIFIER.to_vec();
    bytes.extend(words(&[RGBA16F, 2, size, size, 0, 0, 6, 2, scheme]));
    bytes.extend(words(&[DESCRIPTOR as u32, descriptor.len() as u32, keys as u32, KEYS.len() as u32]));
    bytes.extend([0; 16]);
    for (offset, level) in places {
        bytes.extend([offset as u64, level.stored.len() as u64, level.raw].into_iter().flat_map(u64::to_le_bytes));
    }
    bytes.extend(descriptor);
    bytes.extend(KEYS);
    bytes.resize(data, 0);
    [bytes, small.stored, large.stored].concat()
}

/// Six faces of `side` x `side` texels: 1, 2, 0.5, alpha 1.
fn texels(side: usize) -> Vec<u8> {
    [0, 0x3c, 0, 0x40, 0, 0x38, 0, 0x3c].repeat(6 * side * side)
}

fn raw() -> Vec<u8> {
    file(2, 0, [2, 1].map(|side| Level { stored: texels(side), raw: texels(side).len() as u64 }))
}

/// A frame of Zstandard with one block of `bytes` as they are; the size stands in the head.
fn zstd_stored(bytes: &[u8]) -> Vec<u8> {
    let block = (bytes.len() as u32) << 3 | 1;
    [&[0x28, 0xb5, 0x2f, 0xfd, 0x20, bytes.len() as u8][..], &block.to_le_bytes()[..3], bytes].concat()
}

/// A frame of `blocks` blocks, each 128 KiB of zeros in four bytes.
fn zstd_zeros(blocks: usize) -> Vec<u8> {
    let block = |last: u32| (128_u32 << 13 | 1 << 1 | last).to_le_bytes()[..3].to_vec();
    // No size in the head, and a window of 128 KiB.
    let mut frame = vec![0x28, 0xb5, 0x2f, 0xfd, 0x00, 0x38];
    for i in 0..blocks {
        frame.extend(block(u32::from(i + 1 == blocks)));
        frame.push(0);
    }
    frame
}

fn zstd() -> Vec<u8> {
    file(2, 2, [2, 1].map(|side| Level { stored: zstd_stored(&texels(side)), raw: texels(side).len() as u64 }))
}

/// A file whose large level is `stored`, said to hold `raw` bytes.
fn zstd_level(size: u32, stored: Vec<u8>, raw: u64) -> Vec<u8> {
    let small = texels(1);
    let side = u64::from((size / 2).max(1));
    let small = if side == 1 { zstd_stored(&small) } else { zstd_zeros((48 * side * side).div_ceil(1 << 17) as usize) };
    file(size, 2, [Level { stored, raw }, Level { stored: small, raw: 48 * side * side }])
}

pub(crate) fn good() -> Vec<Good> {
    let header = |bytes: &[u8]| crate::bytes::find(bytes, KEYS) + KEYS.len();
    let (raw, zstd) = (raw(), zstd());
    vec![Good::new("raw.ktx2", header(&raw), raw), Good::new("zstd.ktx2", header(&zstd), zstd)]
}

/// Offset of the fields of a level in the index: where it lies, its bytes, its bytes when inflated.
const fn entry(level: usize, field: usize) -> usize {
    INDEX + 24 * level + 8 * field
}

fn bad_structure() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let raw = raw();
    let word = |at: usize, value: u32| patched(&raw, at, &value.to_le_bytes());
    let long = |at: usize, value: u64| patched(&raw, at, &value.to_le_bytes());
    let size = |size: u32| patched(&raw, 20, &words(&[size, size]));
    let mut same_place = raw.clone();
    same_place.copy_within(entry(0, 0)..entry(0, 1), entry(1, 0));
    vec![
        ("magic", "the last bytes of the identifier were converted", patched(&raw, 8, b"\n\n\n\n")),
        ("cut-identifier", "cut within the identifier", raw[..7].into()),
        ("cut-header", "cut within the header", raw[..40].into()),
        ("cut-index", "cut within the index of the levels", raw[..INDEX + 30].into()),
        ("cut-descriptor", "cut within the data format", raw[..DESCRIPTOR + 20].into()),
        ("cut-levels", "cut before the levels", raw[..entry(0, 0) + 160].into()),
        ("cut-last", "cut before the last byte", raw[..raw.len() - 1].into()),
        ("format-zero", "no Vulkan format", word(12, 0)),
        ("format-unknown", "the Vulkan format 4294967295", word(12, u32::MAX)),
        ("format-bytes", "RGBA in 8 bits", word(12, 43)),
        ("size-zero", "faces of 0 x 0", size(0)),
        ("size-absurd", "faces of 100000 x 100000", size(100_000)),
        ("size-overflow", "faces of 2^32 - 1", size(u32::MAX)),
        ("size-promise", "faces of 4096 x 4096 in 240 bytes", size(4096)),
        ("not-square", "faces of 2 x 4", word(24, 4)),
        ("deep", "a depth of 6", word(28, 6)),
        ("layers", "an array of 2^32 - 1", word(32, u32::MAX)),
        ("faces-none", "0 faces", word(36, 0)),
        ("faces-one", "1 face", word(36, 1)),
        ("faces-many", "2^32 - 1 faces", word(36, u32::MAX)),
        ("levels-many", "3 levels of faces of 2 x 2", word(40, 3)),
        ("levels-absurd", "2^32 - 1 levels", word(40, u32::MAX)),
        ("scheme-basis", "supercompression 1, BasisLZ", word(44, 1)),
        ("scheme-unknown", "supercompression 77", word(44, 77)),
        ("descriptor-outside", "the data format lies behind the end", word(48, 0xffff_fff0)),
        ("descriptor-long", "the data format is 4 GiB long", word(52, u32::MAX)),
        ("keys-outside", "the keys lie behind the end", word(56, 0xffff_fff0)),
        ("keys-over-levels", "the keys reach into the levels", word(60, 60)),
        ("global-data", "global data lies over the header", patched(&raw, 64, &words(&[8, 0, 8, 0]))),
        ("level-outside", "a level lies behind the end", long(entry(0, 0), 1 << 40)),
        ("level-wraps", "place and length of a level overflow", long(entry(0, 0), u64::MAX - 8)),
        ("level-on-header", "a level lies on the header", long(entry(1, 0), 0)),
        ("levels-overlap", "two levels lie at the same place", same_place),
        ("levels-share", "two levels share bytes", long(entry(0, 0), 265)),
        ("level-empty", "a level of no bytes", long(entry(0, 1), 0)),
        ("level-short", "a level of one byte too few", long(entry(0, 1), 191)),
        ("level-raw-size", "a level that says it is 2^64 - 1 bytes", long(entry(0, 2), u64::MAX)),
        ("orientation", "faces upside down", patched(&raw, DESCRIPTOR + 92 + 4 + 15, b"ru")),
        ("transfer", "values in sRGB", patched(&raw, DESCRIPTOR + 4 + 8 + 2, &[2])),
        ("nan", "a texel is NaN", patched(&raw, raw.len() - 8, &[0, 0x7e])),
    ]
}

fn bad_zstd() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let stored = zstd_stored(&texels(2));
    let level = |stored: Vec<u8>| zstd_level(2, stored, 192);
    let more = zstd_stored(&[texels(2), vec![0; 8]].concat());
    vec![
        ("zstd-magic", "a level is no frame of Zstandard", level(patched(&stored, 0, &[0]))),
        ("zstd-cut", "a frame is cut", level(stored[..stored.len() - 1].into())),
        ("zstd-empty", "a frame of nothing", level(zstd_stored(&[]))),
        ("zstd-short", "a frame of fewer bytes than the level", level(zstd_stored(&texels(2)[..184]))),
        ("zstd-more", "a frame of more bytes than the level", level(more)),
        ("zstd-block", "a block of the reserved type", level(patched(&stored, 6, &[stored[6] | 6]))),
        ("zstd-window", "a window of 2 GiB", level(patched(&stored, 4, &[0x00, 21 << 3]))),
        ("zstd-dictionary", "a dictionary is needed", level(patched(&stored, 4, &[0x21, 7]))),
        ("zstd-skipped", "a frame to be skipped, of 4 GiB", level([&[0x50, 0x2a, 0x4d, 0x18][..], &[255; 4]].concat())),
        ("bomb-level", "1 GiB of zeros in place of 192 bytes", zstd_level(2, zstd_zeros(8192)[..4096].into(), 192)),
        ("bomb-small", "16 MiB of zeros in place of 192 bytes", zstd_level(2, zstd_zeros(128), 192)),
        ("bomb-promise", "768 MiB promised in 100 bytes", zstd_level(4096, zstd_zeros(24), 48 << 24)),
        ("bomb-half", "6 MiB promised, of which the frame has half", zstd_level(362, zstd_zeros(24), 48 * 362 * 362)),
    ]
}

pub(crate) fn bad() -> Vec<Bad> {
    corpus::bad("ktx2", [bad_structure(), bad_zstd()].concat())
}
