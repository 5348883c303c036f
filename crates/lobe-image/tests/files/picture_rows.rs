//! Pictures by rows are the pictures that are read whole.

use std::io::Cursor;

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
    while let Some(bands) = rows.next_bands()? {
        for band in bands {
            texels[band.first_row * width..][..band.texels.len()].copy_from_slice(&band.texels);
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

/// Files of several bands: larger than what is decoded together.
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
