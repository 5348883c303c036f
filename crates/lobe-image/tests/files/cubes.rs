//! Cube maps: every format written and read back, and bytes checked by hand.

use std::fs;
use std::path::Path;

use lobe_image::{
    CubeTexture, FileFormat, ImageError, PictureReadOptions, PictureReadReport, PictureWriteReport, TexelFormat,
    TextureNotes, encode_cube_texture, ktx_sh, mip_level_count, mip_level_size, read_cube_texture_bytes,
    read_picture_bytes, write_cube_texture,
};

/// Six colors that no rotation or exchange of faces maps onto each other.
const COLORS: [[f32; 3]; 6] =
    [[1.0, 0.25, 0.5], [0.5, 2.0, 0.125], [4.0, 4.0, 8.0], [0.25, 0.5, 0.75], [1.5, 1.0, 3.0], [0.125, 0.25, 6.0]];

/// Every face has its own color, rising to the right and, faster, downwards, with a spot in one corner.
pub(crate) fn colored_faces(size: usize) -> Vec<[f32; 3]> {
    let mut texels = Vec::new();
    for color in COLORS {
        for y in 0..size {
            for x in 0..size {
                let ramp = 1.0 + (x as f32 + 2.0 * y as f32) / (2 * size) as f32;
                let spot = if 4 * x >= 3 * size && 8 * y < size { 2.0 } else { 1.0 };
                texels.push(color.map(|c| c * ramp * spot));
            }
        }
    }
    texels
}

/// Levels of colored faces, each with its size.
pub(crate) type Levels = Vec<(usize, Vec<[f32; 3]>)>;

/// All levels from a size down to 1.
pub(crate) fn all_levels(size: usize) -> Levels {
    levels(&(0..mip_level_count(size)).map(|k| mip_level_size(size, k)).collect::<Vec<_>>())
}

pub(crate) fn levels(sizes: &[usize]) -> Levels {
    sizes.iter().map(|size| (*size, colored_faces(*size))).collect()
}

/// Writes levels as a file.
fn write(path: &Path, levels: &Levels, texels: TexelFormat, zstd: bool) -> Result<PictureWriteReport, ImageError> {
    let levels: Vec<_> = levels.iter().map(|(size, texels)| (*size, texels.as_slice())).collect();
    write_cube_texture(path, &levels, texels, zstd, &TextureNotes::default())
}

pub(crate) fn encoded(name: &str, levels: &Levels, texels: TexelFormat, zstd: bool) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let report = write(&path, levels, texels, zstd).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(report.clamped, 0, "{name} {texels}: texels clamped");
    let files: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|f| f.unwrap().file_name()).collect();
    assert_eq!(files, [name], "nothing temporary is left");
    fs::read(path).unwrap()
}

pub(crate) fn read(bytes: &[u8]) -> Result<(CubeTexture, PictureReadReport), ImageError> {
    read_cube_texture_bytes(bytes, "test", &PictureReadOptions::default())
}

/// The largest error of a channel, relative to the largest channel of its texel.
fn error_of(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
    assert_eq!(a.len(), b.len(), "texels");
    let error = |(a, b): (&[f32; 3], &[f32; 3])| {
        let largest = a.iter().copied().fold(0.0, f32::max);
        a.iter().zip(b).fold(0.0_f32, |e, (a, b)| e.max((a - b).abs())) / largest
    };
    a.iter().zip(b).map(error).fold(0.0, f32::max)
}

/// The texel formats written, each with its error.
pub(crate) fn formats() -> Vec<(TexelFormat, f32)> {
    vec![
        (TexelFormat::Rgba32F, 0.0),
        (TexelFormat::Rgba16F, 5e-4),
        (TexelFormat::Rgb9e5, 1.0 / 511.0),
        (TexelFormat::R11G11B10F, 1.0 / 64.0),
        // Blocks of a ramp with a spot in them: two colors and sixteen steps between.
        (TexelFormat::Bc6h, 0.12),
    ]
}

/// Every container, with whether it is compressed.
const CONTAINERS: [(&str, bool); 3] = [("a.ktx2", false), ("a.ktx2", true), ("a.dds", false)];

#[test]
fn colored_faces_come_back_the_same_way_round_in_every_format() {
    for size in [1, 2, 5, 16, 30] {
        let chain = all_levels(size);
        for (texels, tolerance) in formats() {
            for (name, zstd) in CONTAINERS {
                let (back, report) = read(&encoded(name, &chain, texels, zstd)).unwrap_or_else(|e| panic!("{e}"));
                assert_eq!(back.levels.len(), chain.len(), "levels of {name} {texels} {size}");
                for ((side, a), (_, b)) in chain.iter().zip(&back.levels) {
                    let error = error_of(a, b);
                    assert!(error <= tolerance, "{name} {texels} zstd {zstd}, {size} to {side}: {error}");
                }
                let format = if name == "a.dds" { FileFormat::Dds } else { FileFormat::Ktx2 };
                assert_eq!((report.format, report.width, report.height), (format, size, size), "{name}: report");
                assert_eq!(report.notes, [format!("the texels are {texels}")], "{name}: notes");
            }
        }
    }
}

#[test]
fn a_part_of_a_chain_keeps_its_levels() {
    let chain = levels(&[40, 20, 10]);
    for (name, zstd) in CONTAINERS {
        let (back, report) = read(&encoded(name, &chain, TexelFormat::Rgba32F, zstd)).unwrap();
        assert_eq!((report.levels, &back.levels), (3, &chain), "{name}");
    }
}

#[test]
fn the_bytes_of_a_ktx2_file_are_those_of_the_specification() {
    let size = 2;
    let chain = all_levels(size);
    let bytes = encoded("a.ktx2", &chain, TexelFormat::Rgb9e5, false);
    let word = |at: usize| u32::from_le_bytes(bytes[at..][..4].try_into().unwrap());
    let long = |at: usize| u64::from_le_bytes(bytes[at..][..8].try_into().unwrap());
    assert_eq!(bytes[..12], *b"\xabKTX 20\xbb\r\n\x1a\n", "identifier");
    // vkFormat, typeSize, width, height, depth, layers, faces, levels, scheme.
    let fields: Vec<u32> = (12..48).step_by(4).map(word).collect();
    assert_eq!(fields, [123, 4, 2, 2, 0, 0, 6, 2, 0], "header");
    // Descriptor after the index of two levels: total length 4 + 24 + 6 samples of 16.
    assert_eq!([word(48), word(52)], [80 + 48, 124], "place of the descriptor");
    assert_eq!([word(56), long(64) as u32, long(72) as u32], [128 + 124, 0, 0], "keys follow, no global data");
    let descriptor = &bytes[128..252];
    // Total size; vendor and type 0; version 2, block size 120; model RGBSDA, BT.709, linear, straight alpha;
    // blocks of 1 x 1; 4 bytes in plane 0.
    let head = [124, 0, 120 << 16 | 2, 0x0001_0101, 0, 4, 0];
    let found: Vec<u32> = (0..28).step_by(4).map(|at| word(128 + at)).collect();
    assert_eq!(found, head, "descriptor");
    // Per color: nine bits of mantissa (stored less one) with the upper value 8448 of the specification's example,
    // then the exponent at bit 27, five bits, with the bias 15 and at most 31.
    for (color, sample) in descriptor[28..].chunks(32).enumerate() {
        let at = color as u8;
        assert_eq!(sample[..16], [9 * at, 0, 8, at, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x21, 0, 0], "mantissa {color}");
        assert_eq!(sample[16..], [27, 0, 4, 0x20 | at, 0, 0, 0, 0, 15, 0, 0, 0, 31, 0, 0, 0], "exponent {color}");
    }
    let keys = &bytes[252..252 + word(60) as usize];
    assert_eq!(keys[..24], *b"\x12\0\0\0KTXorientation\0rd\0\0\0", "orientation");
    assert!(keys[28..].starts_with(b"KTXwriter\0lobe "), "writer: {:?}", String::from_utf8_lossy(keys));
    // The smaller level lies first, both without gaps: six texels, then 24.
    assert_eq!([long(80 + 24), long(80 + 32), long(80 + 40)], [252 + word(60) as u64, 24, 24], "level 1");
    assert_eq!([long(80), long(88), long(96)], [252 + word(60) as u64 + 24, 96, 96], "level 0");
    assert_eq!(bytes.len() as u64, long(80) + long(88), "nothing after the picture");
    // (4, 4, 8) of face 2 at the ramp's 1: 8 is 256 steps of 2^-5, exponent 15 + 9 - 5 = 19.
    assert_eq!(word(long(80) as usize + 2 * 16), 19 << 27 | 256 << 18 | 128 << 9 | 128, "first texel of face +Y");
}

#[test]
fn the_bytes_of_a_dds_file_are_those_of_the_header() {
    let chain = all_levels(4);
    let bytes = encoded("a.dds", &chain, TexelFormat::Rgba16F, false);
    let word = |at: usize| u32::from_le_bytes(bytes[at..][..4].try_into().unwrap());
    assert_eq!(bytes[..4], *b"DDS ", "magic");
    assert_eq!(
        [word(4), word(12), word(16), word(20), word(28)],
        [124, 4, 4, 32, 3],
        "size, height, width, pitch, levels"
    );
    assert_eq!([word(76), word(80)], [32, 4], "format by letters");
    assert_eq!(word(84), 113, "RGBA16F, without a second header");
    assert_eq!([word(108), word(112)], [0x40_1008, 0xfe00], "a cube of six faces with levels");
    // A face has 16, 4 and 1 texels of eight bytes.
    assert_eq!(bytes.len(), 128 + 6 * 21 * 8, "length");
    let second_face = 128 + 21 * 8;
    assert_eq!(bytes[second_face..][..8], [0, 0x38, 0, 0x40, 0, 0x30, 0, 0x3c], "0.5, 2, 0.125, 1 of face -X");
    let bytes = encoded("a.dds", &chain, TexelFormat::Rgb9e5, false);
    let word = |at: usize| u32::from_le_bytes(bytes[at..][..4].try_into().unwrap());
    assert_eq!(bytes[84..88], *b"DX10", "the second header follows");
    assert_eq!([128, 132, 136, 140, 144].map(word), [67, 3, 4, 1, 3], "RGB9E5, 2D, cube, one of them, opaque");
    assert_eq!(bytes.len(), 148 + 6 * 21 * 4, "length");
}

#[test]
fn the_bytes_of_a_ktx_file_are_those_that_filament_reads() {
    let bytes = encoded("a.ktx", &all_levels(2), TexelFormat::R11G11B10F, false);
    let word = |at: usize| u32::from_le_bytes(bytes[at..][..4].try_into().unwrap());
    assert_eq!(bytes[..12], *b"\xabKTX 11\xbb\r\n\x1a\n", "identifier");
    let numbers: Vec<u32> = (12..64).step_by(4).map(word).collect();
    // Byte order, type, its size, format, internal format, base format, size, depth, elements, faces, levels, keys.
    assert_eq!(numbers, [0x0403_0201, 0x8c3a, 4, 0x1907, 0x8c3a, 0x1907, 2, 2, 0, 0, 6, 2, 0], "header");
    assert_eq!([word(64), word(68 + 6 * 16)], [16, 4], "bytes of a face of either level");
    assert_eq!(bytes.len(), 64 + 4 + 6 * 16 + 4 + 6 * 4, "length");
    // Face -X begins with (0.5, 2, 0.125): exponents 14, 16 and 12.
    assert_eq!(word(68 + 16), 14 << 6 | (16 << 6) << 11 | (12 << 5) << 22, "first texel of face -X");
}

#[test]
fn what_a_format_cannot_hold_is_clamped_and_counted() {
    let mut chain = levels(&[4]);
    chain[0].1[0] = [-1.0, 1.0, 1e6];
    chain[0].1[1] = [f32::NAN, 1.0, 1.0];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ktx2");
    let write = |texels| write(&path, &chain, texels, false).unwrap().clamped;
    assert_eq!(write(TexelFormat::Rgba32F), 0, "float holds all");
    assert_eq!(write(TexelFormat::Rgba16F), 1, "half holds NaN but not a million");
    let error = read(&fs::read(&path).unwrap()).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("1 texel is NaN") && error.contains("column 1, row 0"), "{error}");
    assert_eq!(write(TexelFormat::Rgb9e5), 2, "neither NaN nor negative values");
    let (back, _) = read(&fs::read(&path).unwrap()).unwrap();
    assert_eq!(back.levels[0].1[0], [0.0, 0.0, 65408.0], "the largest value, beside which 1 is nothing");
    assert_eq!(back.levels[0].1[1], [0.0, 1.0, 1.0], "NaN is 0");
}

#[test]
fn what_cannot_be_written_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let chain = levels(&[2]);
    let refused = |name: &str, texels, zstd| {
        let error = write(&folder.path().join(name), &chain, texels, zstd).unwrap_err();
        assert!(matches!(error, ImageError::Options(_)), "{name}: {error:?}");
        error.to_string()
    };
    assert!(refused("a.exr", TexelFormat::Rgba16F, false).contains(".ktx2, .ktx or .dds"), "another extension");
    assert!(refused("a.ktx", TexelFormat::Rgba16F, false).contains("R11G11B10F"), "another format in .ktx");
    assert!(refused("a.dds", TexelFormat::Rgba16F, true).contains("Zstandard"), "Zstandard in DDS");
    assert!(refused("a.dds", TexelFormat::Bc6hSigned, false).contains("read, not written"), "signed BC6H");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing was written");
}

#[test]
fn a_texture_is_no_picture_and_a_picture_no_texture() {
    let bytes = encoded("a.dds", &levels(&[4]), TexelFormat::Rgba32F, false);
    let error = read_picture_bytes(&bytes, "test", &PictureReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("cube map") && error.contains("DDS"), "{error}");
    let error = read(include_bytes!("../data/dwaa.exr")).unwrap_err().to_string();
    assert!(error.contains("cube map in KTX2, KTX, DDS or OpenEXR expected"), "{error}");
}

#[test]
fn dds_files_with_and_without_a_second_header_are_read() {
    let chain = all_levels(8);
    let old = encoded("a.dds", &chain, TexelFormat::Rgba16F, false);
    // The same with a second header: RGBA16F, 2D, cube, one of them, opaque.
    let second = [10_u32, 3, 4, 1, 3].map(u32::to_le_bytes).concat();
    let mut new = [&old[..84], b"DX10", &old[88..128], &second, &old[128..]].concat();
    assert_eq!(read(&new).unwrap().0, read(&old).unwrap().0, "number 113 is RGBA16F");
    new[136..140].fill(0);
    new[112..116].fill(0);
    assert!(read(&new).unwrap_err().to_string().contains("6 faces"), "no cube");
    let mut one = old.clone();
    one[112..116].copy_from_slice(&0x0600u32.to_le_bytes());
    assert!(read(&one).unwrap_err().to_string().contains("6 faces"), "one face of six");
}

#[test]
fn signed_bc6h_is_read() {
    // Ten bits with sign c stand for (|c| 32768 + 16384)/512 of fifteen, of which 31/32 are the bits of a half: -231
    // for nearly -0.5, in both ends of one region.
    let chain = levels(&[4]);
    let mut bytes = encoded("a.dds", &chain, TexelFormat::Rgb9e5, false);
    bytes.truncate(148);
    bytes[128..132].copy_from_slice(&96u32.to_le_bytes());
    // Mode 11: 00011, then red of -231 in ten bits and the rest 0, in both ends.
    let red = u128::from((-231i32 as u32) & 0x3ff);
    let block = (0b00011 | red << 5 | red << 35).to_le_bytes();
    bytes.extend(block.repeat(6));
    let (back, report) = read(&bytes).unwrap();
    let texel = back.levels[0].1[95];
    assert!((texel[0] + 0.5).abs() < 0.01 && texel[1] == 0.0, "{texel:?}");
    assert_eq!((report.negative, report.levels), (96, 1), "negative texels are kept and counted");
}

#[test]
fn other_primaries_of_a_ktx2_are_noted_or_converted() {
    /// The offset of the primaries in the descriptor, which lies behind the header and the index of one level.
    const PRIMARIES: usize = 80 + 24 + 4 + 8 + 1;
    let mut bytes = encoded("a.ktx2", &levels(&[4]), TexelFormat::Rgba32F, false);
    assert_eq!(bytes[PRIMARIES], 1, "Rec. 709");
    let converting = PictureReadOptions::default().to_rec_709(true);
    // CIE XYZ, which no matrix between primaries reaches.
    bytes[PRIMARIES] = 5;
    let (_, report) = read_cube_texture_bytes(&bytes, "test", &converting).unwrap();
    assert!(report.notes[1].ends_with("how they are converted is not known"), "{:?}", report.notes);
    // Rec. 2020.
    bytes[PRIMARIES] = 4;
    let (kept, report) = read(&bytes).unwrap();
    assert!(report.notes[1].ends_with("the values are taken as they are"), "{:?}", report.notes);
    let (converted, report) = read_cube_texture_bytes(&bytes, "test", &converting).unwrap();
    assert!(report.notes[1].ends_with("they are converted to those of Rec. 709"), "{:?}", report.notes);
    // ITU-R BT.2087, rounded to four digits.
    const ROUNDED: f32 = 2e-4;
    const LARGEST: f32 = 32.0;
    let matrix = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
    for (found, color) in converted.levels[0].1.iter().zip(&kept.levels[0].1) {
        assert!(color.iter().all(|c| *c < LARGEST), "{color:?}");
        let expected = matrix.map(|row: [f32; 3]| row[0] * color[0] + row[1] * color[1] + row[2] * color[2]);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < ROUNDED * LARGEST, "{found} against {expected}");
        }
    }
}

#[test]
fn a_ktx_keeps_the_light_of_diffuse_surfaces_as_text_and_its_texels_as_they_were() {
    let texels = colored_faces(4);
    let sh: [[f64; 3]; 9] = std::array::from_fn(|i| [0.1 * i as f64, -1.0 / (1.0 + i as f64), 1e-7]);
    let write = |name: &str, sh| {
        let notes = TextureNotes { mapping: None, sh };
        let format = if name.ends_with(".ktx") { TexelFormat::R11G11B10F } else { TexelFormat::Rgba16F };
        encode_cube_texture(Path::new(name), &[(4, texels.as_slice())], format, false, &notes).unwrap().0
    };
    let (with, without) = (write("a.ktx", Some(sh)), write("a.ktx", None));
    assert_eq!(ktx_sh(&with, "test").unwrap(), Some(sh), "every digit");
    assert_eq!(ktx_sh(&without, "test").unwrap(), None, "no key");
    let read = |bytes: &[u8]| read_cube_texture_bytes(bytes, "test", &PictureReadOptions::default()).unwrap().0;
    assert_eq!(read(&with), read(&without), "the texels behind the key");
    // The layout by hand: the bytes of all entries, those of the first one, the key, a zero.
    let word = |at: usize| u32::from_le_bytes(with[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((word(60), &with[68..71]), ((4 + word(64)).next_multiple_of(4), &b"sh\0"[..]), "the first entry");
    let damaged = [&with[..71], b"x", &with[72..]].concat();
    let error = ktx_sh(&damaged, "test").unwrap_err().to_string();
    assert!(error.contains("nine colors"), "{error}");
}
