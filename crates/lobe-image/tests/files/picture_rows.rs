//! Pictures by rows are the pictures that are read whole.

use std::io::{self, Cursor, Read, Seek, SeekFrom};

use exr::prelude::{Blocks, Compression, Encoding, LineOrder, SampleType, Vec2};
use lobe_image::{
    ImageError, Nonfinite, Picture, PictureReadOptions, PictureReadReport, PictureRows, PictureWriteOptions,
    encode_picture, read_picture_bytes,
};
use lobe_testkit::Random;

use crate::exr_files::{SCAN_LINES, exr_file, exr_picture, exr_with_chromaticities, planes, rgb_part};
use crate::malformed::small_files;

/// The picture of all rows; none if it has to be read whole.
fn by_rows(bytes: &[u8], options: &PictureReadOptions) -> Result<Option<(Picture, PictureReadReport)>, ImageError> {
    let Some(mut rows) = PictureRows::new(Cursor::new(bytes), "test", options)? else { return Ok(None) };
    let (width, height) = (rows.report().width, rows.report().height);
    let mut texels = vec![[0.0; 3]; width * height];
    while let Some(strips) = rows.next_strips()? {
        for strip in strips {
            texels[strip.first_row * width..][..strip.texels.len()].copy_from_slice(&strip.texels);
        }
    }
    let report = rows.finish()?;
    Ok(Some((Picture::new(width, height, texels)?, report)))
}

/// Asserts that rows and the whole picture are alike, or fail alike; whether the picture comes by rows, or failed.
fn assert_alike(bytes: &[u8], options: &PictureReadOptions, what: &str) -> bool {
    let whole = read_picture_bytes(bytes, "test", options).map_err(|e| e.to_string());
    match by_rows(bytes, options).map_err(|e| e.to_string()).transpose() {
        Some(rows) => assert!(rows == whole, "{what}: by rows {:?}, whole {:?}", reports(&rows), reports(&whole)),
        None => return false,
    }
    true
}

fn reports(read: &Result<(Picture, PictureReadReport), String>) -> Result<&PictureReadReport, &String> {
    read.as_ref().map(|(_, report)| report)
}

/// Files with windows of their own, and of other orders of rows.
fn larger_files() -> Vec<(String, Vec<u8>)> {
    let size = (600, 200);
    let mut random = Random::new(3);
    let texel = |_| [(); 3].map(|()| (20.0 * random.signed()).exp2() as f32);
    let texels = (0..size.0 * size.1).map(texel).collect();
    let picture = Picture::new(size.0, size.1, texels).unwrap();
    let encoded = |name: &str| {
        encode_picture(name.as_ref(), size.0, picture.pixels(), &PictureWriteOptions::default()).unwrap().0
    };
    let mut files: Vec<_> = ["a.hdr", "a.pfm", "a.exr"].map(|name| (name.to_owned(), encoded(name))).into();
    let all = planes(&["R", "G", "B"], SampleType::F32, size);
    let decreasing =
        Encoding { compression: Compression::ZIP1, blocks: Blocks::ScanLines, line_order: LineOrder::Decreasing };
    files.push(("from the bottom".into(), exr_picture(size, decreasing, all)));
    for (position, data) in
        [((-10, -20), (640, 260)), ((30, 17), (100, 90)), ((0, -5), size), ((0, 190), size), ((-7, 3), size)]
    {
        let part = rgb_part(data);
        let part = crate::exr_files::Part {
            position,
            planes: planes(&["R", "G", "B"], SampleType::F16, data),
            size: data,
            ..part
        };
        files.push((format!("data window of {data:?} at {position:?}"), exr_file(size, vec![part])));
    }
    files
}

#[test]
fn rows_are_those_of_the_whole_picture() {
    let options = PictureReadOptions::default();
    for (what, bytes) in small_files().into_iter().chain(larger_files()) {
        let comes_by_rows = assert_alike(&bytes, &options, &what);
        assert!(comes_by_rows != what.contains("Tiles"), "{what}: comes by rows");
    }
}

#[test]
fn what_is_decoded_at_a_time_joins_without_a_seam() {
    // Of 2¹⁹ texels at a time, OpenEXR; of others less.
    let size = (1100, 1000);
    for line_order in [LineOrder::Increasing, LineOrder::Decreasing] {
        let encoding = Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order };
        let bytes = exr_picture(size, encoding, planes(&["R", "G", "B"], SampleType::F16, size));
        assert!(assert_alike(&bytes, &PictureReadOptions::default(), "several batches"), "{line_order:?}");
        let mut rows = PictureRows::new(Cursor::new(&bytes), "test", &PictureReadOptions::default()).unwrap().unwrap();
        let times = std::iter::from_fn(|| rows.next_strips().unwrap()).count();
        assert!(times > 1, "{line_order:?}: {times}");
    }
}

/// A file whose disk fails behind some bytes.
struct Failing<'a>(Cursor<&'a [u8]>, u64);

impl Read for Failing<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.0.position() >= self.1 {
            return Err(io::Error::other("the disk is gone"));
        }
        let left = (self.1 - self.0.position()) as usize;
        let count = buffer.len().min(left);
        self.0.read(&mut buffer[..count])
    }
}

impl Seek for Failing<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}

#[test]
fn a_disk_that_fails_is_told_as_such_and_ends_the_reading() {
    for (what, bytes) in larger_files().into_iter().filter(|(what, _)| ["a.hdr", "a.pfm", "a.exr"].contains(&&**what)) {
        let source = Failing(Cursor::new(&bytes), 3 * bytes.len() as u64 / 4);
        let mut rows = PictureRows::new(source, "test", &PictureReadOptions::default()).unwrap().unwrap();
        let error = loop {
            match rows.next_strips() {
                Ok(Some(_)) => {}
                Ok(None) => panic!("{what}: the end of a file that cannot be read"),
                Err(error) => break error,
            }
        };
        assert!(matches!(error, ImageError::Io { .. }), "{what}: {error:?}");
        assert!(rows.next_strips().is_err() && rows.finish().is_err(), "{what}: and nothing behind it");
    }
}

#[test]
fn a_radiance_file_without_end_is_refused_by_its_beginning() {
    let endless = |start: &[u8], again: &[u8]| [start, &again.repeat(3 << 20)].concat();
    for (what, bytes) in [
        ("runs of no columns", endless(b"#?RADIANCE\n\n-Y 4 +X 8\n\x02\x02\x00\x08", b"\0")),
        ("repeat counts of none", endless(b"#?RADIANCE\n\n-Y 4 +X 8\n\x09\x09\x09\x80", b"\x01\x01\x01\0")),
        ("a header that does not end", endless(b"#?RADIANCE\n", b"A")),
    ] {
        let options = PictureReadOptions::default();
        assert!(assert_alike(&bytes, &options, what), "{what}");
        let line = read_picture_bytes(&bytes, "test", &options).unwrap_err().to_string();
        assert!(line.contains("damaged Radiance picture"), "{what}: {line}");
    }
}

#[test]
fn colors_are_converted_and_numbers_judged_row_by_row() {
    let ap1 = exr_with_chromaticities([[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], [0.32168, 0.33767]]);
    assert!(assert_alike(&ap1, &PictureReadOptions::default().to_rec_709(true), "ACES to Rec. 709"));
    assert!(assert_alike(&ap1, &PictureReadOptions::default(), "ACES"));
    let picture = Picture::from_fn(40, 100, |x, y| match (x, y) {
        (7, 90) | (9, 31) | (30, 31) => [f32::NAN, 1.0, 1.0],
        (_, 50) => [-1.0, 0.0, 0.0],
        _ => [1.0; 3],
    });
    // Rows of a portable float map come from the bottom: the first that is no number is not the first from above.
    for name in ["a.pfm", "a.exr"] {
        let options = PictureWriteOptions::default();
        let mut bytes =
            encode_picture(name.as_ref(), 40, Picture::filled(40, 100, [1.0; 3]).pixels(), &options).unwrap().0;
        if name == "a.pfm" {
            let data = bytes.len() - 40 * 100 * 12;
            for (row, line) in picture.pixels().chunks(40).rev().zip(bytes[data..].chunks_mut(40 * 12)) {
                line.copy_from_slice(&row.iter().flatten().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>());
            }
        } else {
            let of = |c: usize| picture.pixels().iter().map(|p| p[c]).collect::<Vec<_>>();
            let mut layers = planes(&["R", "G", "B"], SampleType::F32, (40, 100));
            layers.iter_mut().enumerate().for_each(|(c, plane)| plane.values = of(c));
            bytes = exr_picture((40, 100), SCAN_LINES, layers);
        }
        let zero = PictureReadOptions::default().nonfinite(Nonfinite::Zero);
        assert!(assert_alike(&bytes, &PictureReadOptions::default(), name), "{name}");
        assert!(assert_alike(&bytes, &zero, name), "{name}");
        let (_, report) = by_rows(&bytes, &zero).unwrap().unwrap();
        assert_eq!((report.first_nonfinite, report.nonfinite, report.negative), (Some((9, 31)), 3, 40), "{name}");
    }
}

#[test]
fn cut_and_damaged_files_fail_alike() {
    let options = PictureReadOptions::default().nonfinite(Nonfinite::Zero);
    let mut random = Random::new(17);
    for (what, bytes) in small_files() {
        for length in (0..bytes.len()).step_by(3) {
            assert_alike(&bytes[..length], &options, &format!("{what}, cut to {length}"));
        }
        for _ in 0..40 {
            let mut damaged = bytes.clone();
            let at = random.next_u64() as usize % damaged.len();
            damaged[at] = random.next_u64() as u8;
            assert_alike(&damaged, &options, &format!("{what}, byte {at} is {}", damaged[at]));
        }
    }
    let tiles = exr_picture(
        (40, 40),
        Encoding { blocks: Blocks::Tiles(Vec2(8, 8)), ..SCAN_LINES },
        planes(&["R", "G", "B"], SampleType::F16, (40, 40)),
    );
    assert!(by_rows(&tiles, &options).unwrap().is_none(), "tiles are no rows");
}

#[test]
fn what_is_no_file_or_no_picture_is_told_before_any_row() {
    let options = PictureReadOptions::default();
    let folder = tempfile::tempdir().unwrap();
    let missing = PictureRows::open(folder.path().join("sky.exr"), &options).err().unwrap().to_string();
    assert!(missing.contains("sky.exr"), "{missing}");
    assert!(PictureRows::open(folder.path(), &options).unwrap().is_none(), "a folder");
    let text = PictureRows::new(Cursor::new(b"hello"), "a.txt", &options).err().unwrap().to_string();
    assert!(text.starts_with("a.txt: ") && text.contains("hello"), "{text}");
    let large = PictureRows::new(Cursor::new(b"PF\n4096 2048\n-1\n"), "a.pfm", &options.clone().max_texels(9));
    let large = large.err().unwrap().to_string();
    assert!(large.contains("more than the limit"), "{large}");
}
