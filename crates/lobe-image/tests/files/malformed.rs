//! Damaged, truncated and wrong files: an error of one line, never a panic, never a partial picture.

use std::path::Path;

use exr::prelude::{Blocks, Compression, Encoding, SampleType, Vec2};
use lobe_image::{
    ImageError, Nonfinite, Picture, PictureReadOptions, PictureWriteOptions, ReadOption, encode_picture,
    read_cube_texture, read_picture, read_picture_bytes,
};
use lobe_testkit::Random;

use crate::exr_files::{SCAN_LINES, exr_picture, patch_window, planes, rgb_part};

const SIZE: (usize, usize) = (16, 8);

/// The most panics of the library `exr` in damaged files of one kind of B44. Its differences of halves wrap around, which stops it
/// where overflow is checked, as in a build for tests. 25 were seen in the files of both kinds, and one of a file of ZIP that became one of B44.
const MOST_PANICS_OF_B44: usize = 50;

fn read(bytes: &[u8]) -> Result<Picture, ImageError> {
    read_picture_bytes(bytes, "test", &PictureReadOptions::default()).map(|(map, _)| map)
}

/// The message of an expected error, in one line that begins with the file.
fn message(result: Result<Picture, ImageError>, what: &str) -> String {
    let message = match result {
        Err(error) => error.to_string(),
        Ok(map) => panic!("{what}: an error expected, found a picture of {} x {}", map.width(), map.height()),
    };
    assert!(!message.contains('\n') && message.contains(": "), "{what}: {message:?}");
    assert!(!is_of_panic(&message), "{what}: a reader panicked, {message:?}");
    message
}

/// Whether a message stands for a panic of a reader, which is caught.
pub(crate) fn is_of_panic(message: &str) -> bool {
    message.ends_with("data is damaged and cannot be decoded")
}

fn expect(result: Result<Picture, ImageError>, what: &str, parts: &[&str]) {
    let message = message(result, what);
    assert!(parts.iter().all(|part| message.contains(part)), "{what}: {parts:?} expected in {message:?}");
}

fn small_hdr() -> Vec<u8> {
    let picture = Picture::from_fn(SIZE.0, SIZE.1, |x, y| [1.0 + 0.1 * x as f32, 1.0, 1.0 + 0.2 * y as f32]);
    let options = PictureWriteOptions::default();
    encode_picture(Path::new("a.hdr"), picture.width(), picture.pixels(), &options).unwrap().0
}

fn small_exr(compression: Compression, blocks: Blocks) -> Vec<u8> {
    let encoding = Encoding { compression, blocks, ..SCAN_LINES };
    exr_picture(SIZE, encoding, planes(&["R", "G", "B"], SampleType::F16, SIZE))
}

/// Small valid files of all encodings, with their names.
pub(crate) fn small_files() -> Vec<(String, Vec<u8>)> {
    let mut files = vec![("hdr".to_owned(), small_hdr())];
    let old = [&[128, 64, 32, 129][..], &[1, 1, 1, 15]].concat().repeat(8);
    files.push(("old hdr".into(), [&b"#?RADIANCE\n\n-Y 8 +X 16\n"[..], &old].concat()));
    let compressions = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
    ];
    for compression in compressions {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(8, 8))] {
            files.push((format!("{compression:?} {blocks:?}"), small_exr(compression, blocks)));
        }
    }
    files.push(("dwaa".into(), include_bytes!("../data/dwaa.exr").to_vec()));
    files.push(("dwab".into(), include_bytes!("../data/dwab.exr").to_vec()));
    files
}

#[test]
fn missing_files_and_folders_are_errors_that_name_them() {
    let folder = tempfile::tempdir().unwrap();
    let read = |path: &Path| read_picture(path, &PictureReadOptions::default()).map(|(map, _)| map);
    expect(read(&folder.path().join("sky.exr")), "missing", &["sky.exr", "No such file"]);
    let result = read(folder.path());
    assert!(matches!(result, Err(ImageError::Io { .. })), "{result:?}");
    expect(result, "folder", &["folder"]);
}

#[test]
fn files_that_are_no_pictures_say_what_was_found() {
    expect(read(b""), "empty", &["empty"]);
    expect(read(b"hello, this is text"), "text", &["Radiance", "text beginning with \"hello, this"]);
    expect(read(b"line one\nline two\n"), "two lines", &["text beginning with \"line one\\nline"]);
    expect(read(b"II*\0"), "TIFF", &["TIFF", "convert"]);
    expect(read(b"\0\x01\x02\xff"), "bytes", &["unknown data", "00, 01, 02, ff"]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.hdr");
    std::fs::write(&path, "not a picture").unwrap();
    let result = read_picture(&path, &PictureReadOptions::default()).map(|(map, _)| map);
    expect(result, "text named .hdr", &["sky.hdr", "text beginning with \"not a picture\""]);
}

#[test]
#[cfg(unix)]
fn a_device_without_end_is_refused_by_its_beginning() {
    let result = read_picture("/dev/zero", &PictureReadOptions::default()).map(|(map, _)| map);
    expect(result, "zeros", &["/dev/zero", "unknown data", "00, 00"]);
}

#[test]
fn a_file_longer_than_the_limit_is_refused_by_its_length() {
    let folder = tempfile::tempdir().unwrap();
    let beginnings: [&[u8]; 7] = [
        b"#?RADIANCE\n\n-Y 1 +X 1\n",
        &[0x76, 0x2f, 0x31, 0x01],
        b"PF\n1 1\n-1\n",
        b"\x89PNG\r\n\x1a\n",
        b"\xff\xd8\xff",
        b"\xabKTX 20\xbb\r\n\x1a\n",
        b"DDS ",
    ];
    for beginning in beginnings {
        let path = folder.path().join("sky");
        std::fs::write(&path, beginning).unwrap();
        let length = if cfg!(unix) { 1 << 40 } else { 1 << 20 };
        // A hole, which takes no room on the disk.
        std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(length).unwrap();
        let options = PictureReadOptions::default();
        let options = if cfg!(unix) { options } else { options.max_bytes(1 << 16) };
        let (picture, texture) = (read_picture(&path, &options).err(), read_cube_texture(&path, &options).err());
        for error in [picture, texture] {
            let Some(ImageError::Refused { message, option: ReadOption::MaxBytes, .. }) = &error else {
                panic!("{beginning:?}: {error:?}");
            };
            assert_eq!(*message, format!("the file has {length} bytes, more than the limit of {}", options.max_bytes));
        }
    }
}

#[test]
fn texels_that_take_more_than_the_limit_of_bytes_are_refused_by_that_name() {
    let bytes = b"PF\n4 2\n-1\n".iter().copied().chain([0; 96]).collect::<Vec<u8>>();
    let read = |options: &PictureReadOptions| read_picture_bytes(&bytes, "a.pfm", options);
    assert!(read(&PictureReadOptions::default().max_bytes(96)).is_ok(), "as much as allowed");
    let error = read(&PictureReadOptions::default().max_bytes(95)).unwrap_err();
    assert!(matches!(error, ImageError::Refused { option: ReadOption::MaxBytes, .. }), "{error:?}");
    let text = error.to_string();
    assert!(text.contains("4 x 2") && text.contains("raise max_bytes"), "{text}");
    let error = read(&PictureReadOptions::default().max_bytes(95).max_texels(7)).unwrap_err();
    assert!(matches!(error, ImageError::Refused { option: ReadOption::MaxTexels, .. }), "the lower one: {error:?}");
}

#[test]
fn the_contents_decide_and_not_the_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("really.hdr");
    std::fs::write(&path, small_exr(Compression::ZIP16, Blocks::ScanLines)).unwrap();
    let (_, report) = read_picture(&path, &PictureReadOptions::default()).unwrap();
    assert_eq!(report.format.to_string(), "OpenEXR", "format");
}

#[test]
fn pictures_without_texels_are_errors() {
    for resolution in ["-Y 0 +X 0", "-Y 0 +X 16", "-Y 8 +X 0"] {
        expect(read(format!("#?RADIANCE\n\n{resolution}\n").as_bytes()), resolution, &["no texels"]);
    }
    let mut exr = small_exr(Compression::ZIP16, Blocks::ScanLines);
    patch_window(&mut exr, "displayWindow", [0, 0, -1, -1]);
    message(read(&exr), "exr with an empty display window");
}

#[test]
fn a_large_header_without_data_is_an_error_before_memory_is_taken() {
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 50000 +X 100000\n";
    expect(read(hdr), "hdr", &["100000 x 50000", "limit", "scale it down, or raise max_texels"]);
    let error = read(hdr).unwrap_err();
    assert!(matches!(error, ImageError::Refused { option: ReadOption::MaxTexels, .. }), "{error:?}");
    // This file does not say how many blocks it has, so that the new size contradicts nothing in the header.
    let mut exr = include_bytes!("../data/dwaa.exr").to_vec();
    patch_window(&mut exr, "displayWindow", [0, 0, 99_999, 49_999]);
    patch_window(&mut exr, "dataWindow", [0, 0, 99_999, 49_999]);
    expect(read(&exr), "exr", &["100000 x 50000", "limit"]);
    // Even where the caller allows such sizes, the data must be there before memory is taken for it.
    let options = PictureReadOptions::default().max_texels(usize::MAX);
    let read = |bytes: &[u8]| read_picture_bytes(bytes, "test", &options).map(|(map, _)| map);
    expect(read(hdr), "hdr without limit", &["ends early", "100000 x 50000"]);
    message(read(&exr), "exr without limit");
}

#[test]
fn absurd_numbers_in_headers_are_errors() {
    let max = u32::MAX;
    for resolution in [
        format!("-Y {max} +X {max}"),
        format!("-Y {} +X {}", max / 2, max - 1),
        "-Y 99999999999999999999 +X 1".into(),
        "-Y -8 +X 16".into(),
        "-Y 8".into(),
        "-Y eight +X sixteen".into(),
    ] {
        message(read(format!("#?RADIANCE\n\n{resolution}\n").as_bytes()), &resolution);
    }
    let (low, high) = (i32::MIN, i32::MAX);
    for window in [[0, 0, high, high], [low, low, high, high], [low, 0, low, 0], [high, high, low, low], [5, 5, 4, 4]] {
        for name in ["dataWindow", "displayWindow"] {
            let mut exr = small_exr(Compression::ZIP16, Blocks::ScanLines);
            patch_window(&mut exr, name, window);
            message(read(&exr), &format!("{name} {window:?}"));
        }
    }
}

#[test]
fn every_truncation_of_a_file_is_an_error() {
    for (name, bytes) in small_files() {
        read(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        let step = (bytes.len() / 400).max(1);
        for length in (0..bytes.len()).step_by(step).chain([bytes.len() - 1]) {
            message(read(&bytes[..length]), &format!("{name} cut to {length} of {} bytes", bytes.len()));
        }
    }
}

/// Damages a file in many ways, at single bytes and at eight at once: some of it must be refused, and no reader panics.
pub(crate) fn damage(name: &str, bytes: &[u8], random: &mut Random, reader: impl Fn(&[u8]) -> Result<(), ImageError>) {
    let (mut refused, mut panicked) = (0, 0);
    let mut count = |damaged: &[u8]| {
        if let Err(error) = reader(damaged) {
            refused += 1;
            panicked += usize::from(is_of_panic(&error.to_string()));
        }
    };
    for position in (0..bytes.len()).step_by((bytes.len() / 500).max(1)) {
        for flip in [0xff, 1 << (random.next_u64() % 8)] {
            let mut damaged = bytes.to_vec();
            damaged[position] ^= flip;
            count(&damaged);
        }
    }
    for _ in 0..100 {
        let mut damaged = bytes.to_vec();
        for _ in 0..8 {
            let position = random.next_u64() as usize % damaged.len();
            damaged[position] = random.next_u64() as u8;
        }
        count(&damaged);
    }
    assert!(refused > 0, "{name}: no damage was ever noticed");
    let most = match name {
        _ if name.starts_with("B44") => MOST_PANICS_OF_B44,
        // Damage may make another compression that one.
        _ if bytes.starts_with(b"v/1\x01") => 2,
        _ => 0,
    };
    assert!(panicked <= most, "{name}: the reader panicked at {panicked} files, expected at most {most}");
}

#[test]
fn damaged_bytes_never_panic() {
    let mut random = Random::new(2);
    for (name, bytes) in small_files() {
        damage(&name, &bytes, &mut random, |damaged| read(damaged).map(drop));
    }
}

#[test]
fn endless_repeat_counts_are_an_error() {
    // Each zero count multiplies the next by 256, without end.
    let pixels = [&[128, 64, 32, 129][..], &[1, 1, 1, 0].repeat(20), &[1, 1, 1, 255]].concat();
    let file = [&b"#?RADIANCE\n\n-Y 8 +X 16\n"[..], &pixels, &[0; 1000]].concat();
    message(read(&file), "repeat counts");
}

#[test]
fn a_block_that_is_there_twice_or_missing_is_an_error() {
    let bytes = small_exr(Compression::RLE, Blocks::ScanLines);
    // The table of the offsets of eight rows follows the header; the first row begins right after it.
    let table = (0..bytes.len() - 8)
        .find(|at| bytes[*at..][..8] == (*at as u64 + 64).to_le_bytes())
        .unwrap_or_else(|| panic!("no table of offsets"));
    let mut twice = bytes.clone();
    twice.copy_within(table..table + 8, table + 8);
    expect(read(&twice), "twice", &["table of blocks"]);
    let mut nowhere = bytes.clone();
    nowhere[table..table + 8].fill(0);
    message(read(&nowhere), "an unfinished file has zeros in its table");
}

#[test]
fn non_finite_texels_are_counted_and_refused_or_made_black() {
    let mut part = rgb_part(SIZE);
    for plane in &mut part.planes {
        plane.sample_type = SampleType::F32;
    }
    part.planes[0].values[3 * 16 + 5] = f32::NAN;
    part.planes[1].values[3 * 16 + 5] = f32::INFINITY;
    part.planes[2].values[4 * 16] = f32::NEG_INFINITY;
    part.planes[2].values[7] = -0.5;
    let bytes = exr_picture(SIZE, SCAN_LINES, part.planes);
    expect(read(&bytes), "default", &["2 texels are NaN or infinite", "column 5, row 3", "Nonfinite::Zero"]);
    let error = read(&bytes).unwrap_err();
    assert!(matches!(error, ImageError::Refused { option: ReadOption::Nonfinite, .. }), "{error:?}");
    let options = PictureReadOptions::default().nonfinite(Nonfinite::Zero);
    let (map, report) = read_picture_bytes(&bytes, "test", &options).unwrap();
    assert_eq!((report.nonfinite, report.first_nonfinite, report.negative), (2, Some((5, 3)), 1), "counts");
    assert_eq!(map.pixel(5, 3), [0.0, 0.0, 0.0], "the whole texel is black");
    assert_eq!(map.pixel(7, 0)[2], -0.5, "negative values are kept");
}
