//! Damaged cube maps and pictures: an error of one line, no panic, no memory for false sizes.

use lobe_image::{
    FileFormat, ImageError, PictureReadOptions, TexelFormat, read_cube_texture_bytes, read_picture_bytes,
};
use lobe_testkit::Random;
use png::{BitDepth, ColorType};

use crate::cubes::{all_levels, encoded, formats, levels};
use crate::malformed::{damage, is_of_panic};
use crate::read_pictures::{JPEG, pfm, png};

/// Offset of the index of levels in a KTX2 file.
const INDEX: usize = 80;

fn read(bytes: &[u8]) -> Result<(), ImageError> {
    let options = PictureReadOptions::default();
    if FileFormat::of_bytes(bytes, "test")?.is_texture() {
        return read_cube_texture_bytes(bytes, "test", &options).map(|_| ());
    }
    read_picture_bytes(bytes, "test", &options).map(|_| ())
}

/// The message of an expected error, in one line that begins with the file.
fn message(bytes: &[u8], what: &str) -> String {
    let Err(error) = read(bytes) else { panic!("{what}: an error expected") };
    let message = error.to_string();
    assert!(!message.contains('\n') && message.starts_with("test: "), "{what}: {message:?}");
    assert!(!is_of_panic(&message), "{what}: a reader panicked, {message:?}");
    message
}

fn expect(bytes: &[u8], part: &str) {
    let message = message(bytes, part);
    assert!(message.contains(part), "{part:?} expected in {message:?}");
}

fn patched(bytes: &[u8], at: usize, value: &[u8]) -> Vec<u8> {
    let mut patched = bytes.to_vec();
    patched[at..at + value.len()].copy_from_slice(value);
    patched
}

fn ktx2(zstd: bool) -> Vec<u8> {
    encoded("a.ktx2", &all_levels(8), TexelFormat::Rgba16F, zstd)
}

fn dds() -> Vec<u8> {
    encoded("a.dds", &all_levels(8), TexelFormat::Rgb9e5, false)
}

/// Small valid files, with whether each byte of them matters.
fn small_files() -> Vec<(String, Vec<u8>)> {
    let chain = all_levels(4);
    let mut files = vec![
        ("PFM".to_owned(), pfm("PF\n4 2\n-1.0\n", &[1.5; 24], f32::to_le_bytes)),
        ("gray PFM".into(), pfm("Pf\n4 2\n1.0\n", &[1.5; 8], f32::to_be_bytes)),
        ("PNG".into(), png(ColorType::Rgb, BitDepth::Eight)),
        ("PNG of 16 bits".into(), png(ColorType::Rgba, BitDepth::Sixteen)),
        ("JPEG".into(), JPEG.to_vec()),
    ];
    for (format, _) in formats() {
        for (name, zstd) in [("a.ktx2", false), ("a.ktx2", true), ("a.dds", false)] {
            files.push((format!("{name} {format} zstd {zstd}"), encoded(name, &chain, format, zstd)));
        }
    }
    files
}

#[test]
fn every_truncation_of_a_file_is_an_error() {
    for (name, bytes) in small_files() {
        read(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        // A PNG picture is whole before its last chunk, of twelve bytes, and the checksum of the one before it.
        let end = if name.starts_with("PNG") { bytes.len() - 16 } else { bytes.len() };
        let step = (bytes.len() / 400).max(1);
        for length in (0..end).step_by(step).chain([end - 1]) {
            message(&bytes[..length], &format!("{name} cut to {length} of {} bytes", bytes.len()));
        }
    }
}

#[test]
fn damaged_bytes_never_panic() {
    let mut random = Random::new(3);
    for (name, bytes) in small_files() {
        damage(&name, &bytes, &mut random, read);
    }
}

#[test]
fn ktx2_files_that_are_no_cube_maps_of_light_are_refused_by_name() {
    let bytes = ktx2(false);
    let word = |at: usize, value: u32| patched(&bytes, at, &value.to_le_bytes());
    expect(&word(12, 2), "found the Vulkan format");
    expect(&word(12, 0), "Basis");
    expect(&word(24, 4), "square and flat, these are 8 x 4");
    expect(&word(28, 1), "8 x 8 x 1");
    expect(&word(32, 2), "an array of 2");
    expect(&word(36, 1), "6 faces expected");
    expect(&word(36, 5), "6 faces expected");
    expect(&word(40, 5), "at most 4 levels, not 5");
    message(&word(40, u32::MAX), "four thousand million levels");
    expect(&word(44, 1), "scheme BasisLZ");
    expect(&word(44, 3), "scheme ZLIB");
    // The descriptor lies behind four levels; its third word holds model, primaries and transfer function.
    let transfer = INDEX + 4 * 24 + 4 + 8 + 2;
    assert_eq!(bytes[transfer], 1, "linear");
    expect(&patched(&bytes, transfer, &[2]), "transfer function SRGB");
    let orientation = bytes.windows(3).position(|w| w == b"rd\0").unwrap();
    expect(&patched(&bytes, orientation, b"ru"), "orientation");
    expect(b"\xabKTX 11\xbb\r\n\x1a\n and more", "the header is not all there");
}

#[test]
fn levels_that_overlap_or_have_a_wrong_size_are_errors() {
    for zstd in [false, true] {
        let bytes = ktx2(zstd);
        let entry = |level: usize| INDEX + 24 * level;
        // Level 1 declares the place of level 0.
        let mut overlapping = bytes.clone();
        overlapping.copy_within(entry(0)..entry(0) + 8, entry(1));
        expect(&overlapping, "overlap");
        expect(&patched(&bytes, entry(0), &40u64.to_le_bytes()), "overlap");
        for value in [0, 1, 3071, 3073, u64::MAX] {
            expect(&patched(&bytes, entry(0) + 16, &value.to_le_bytes()), "needs 3072 bytes");
        }
        for value in [u64::MAX, u64::MAX - 1000, 1 << 40] {
            message(&patched(&bytes, entry(0), &value.to_le_bytes()), "offset");
            message(&patched(&bytes, entry(0) + 8, &value.to_le_bytes()), "length");
        }
        message(&patched(&bytes, entry(0) + 8, &0u64.to_le_bytes()), "no bytes");
    }
}

#[test]
fn large_headers_without_data_are_errors_at_once() {
    for size in [6688u32, 100_000, u32::MAX] {
        for zstd in [false, true] {
            let side = size.to_le_bytes();
            let file = patched(&patched(&ktx2(zstd), 20, &side), 24, &side);
            let part = if size == 6688 { "needs" } else { "limit" };
            expect(&file, part);
        }
        let side = size.to_le_bytes();
        let file = patched(&patched(&dds(), 12, &side), 16, &side);
        expect(&file, if size == 6688 { "ends early" } else { "limit" });
    }
    expect(&pfm("PF\n100000 50000\n1\n", &[0.0; 4], f32::to_le_bytes), "limit");
    expect(&pfm("PF\n10000 5000\n1\n", &[0.0; 4], f32::to_le_bytes), "ends early");
    for header in [
        "PF\n-2 1\n1\n",
        "PF\n99999999999999999999 1\n1\n",
        "PF\n2\n",
        "PF\n2 1\n0\n",
        "PF\n2 1\nnan\n",
        "PF\n2 1\n1",
        "PF",
    ] {
        message(header.as_bytes(), header);
    }
}

#[test]
fn a_bomb_of_zstandard_is_an_error_before_memory_is_taken() {
    // One level of 4096 x 4096, 768 MiB of zeros, which Zstandard stores in 24 KiB.
    let zeros = zstd::bulk::compress(&vec![0; 32 << 20], 1).unwrap();
    let one = encoded("a.ktx2", &levels(&[1]), TexelFormat::Rgba16F, true);
    let bomb = |size: u32, promised: u64, data: &[u8]| {
        let offset = u64::from_le_bytes(one[INDEX..INDEX + 8].try_into().unwrap());
        let mut file = one[..offset as usize].to_vec();
        file = patched(&patched(&file, 20, &size.to_le_bytes()), 24, &size.to_le_bytes());
        file = patched(
            &patched(&file, INDEX + 8, &(data.len() as u64).to_le_bytes()),
            INDEX + 16,
            &promised.to_le_bytes(),
        );
        file.extend(data);
        file
    };
    // More bytes than declared, then fewer.
    expect(&bomb(1, 48, &zeros), "more than its 48 bytes");
    expect(&bomb(1, 32 << 20, &zeros), "needs 48 bytes");
    expect(&bomb(4096, (6 * 8) << 24, &zeros[..100]), "needs 805306368 bytes");
    expect(&bomb(4096, (6 * 8) << 24, &[zeros.as_slice(), &[0; 30_000]].concat()), "level 0");
}

#[test]
fn dds_files_that_are_no_cube_maps_of_light_are_refused_by_name() {
    let bytes = dds();
    let word = |at: usize, value: u32| patched(&bytes, at, &value.to_le_bytes());
    expect(&word(4, 100), "124 bytes");
    expect(&word(128, 28), "DXGI format 28");
    expect(&patched(&word(136, 0), 112, &[0; 4]), "6 faces expected");
    expect(&patched(&word(136, 0), 112, &0x600_u32.to_le_bytes()), "some faces");
    expect(&word(140, 5), "array of 5");
    expect(&[word(140, 6), vec![0; 5 * bytes.len()]].concat(), "array of 6");
    expect(&word(12, 4), "square, these are 8 x 4");
    expect(&word(16, 0), "square");
    expect(&word(28, 5), "at most 4 levels, not 5");
    expect(&word(28, u32::MAX), "at most 4 levels");
    expect(&patched(&bytes, 84, b"DXT5"), "DXT5");
}
