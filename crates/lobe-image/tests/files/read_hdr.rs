//! Radiance files of every kind that Lobe reads or refuses.

use lobe_image::{FileFormat, ImageError, Picture, PictureReadOptions, PictureReadReport, read_picture_bytes};

fn read(bytes: &[u8]) -> (Picture, PictureReadReport) {
    read_picture_bytes(bytes, "test.hdr", &PictureReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// A file with these header lines, resolution line and pixel bytes.
fn file(lines: &str, resolution: &str, pixels: &[u8]) -> Vec<u8> {
    [lines.as_bytes(), b"\n", resolution.as_bytes(), b"\n", pixels].concat()
}

const HEADER: &str = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n";

/// 16 x 8 texels of which the left half is (128, 64, 32)/256 · 2 and the right half four times that.
fn expected(x: usize) -> [f32; 3] {
    let scale = if x < 8 { 1.0 } else { 4.0 };
    [scale, 0.5 * scale, 0.25 * scale]
}

const LEFT: [u8; 4] = [128, 64, 32, 129];
const RIGHT: [u8; 4] = [128, 64, 32, 131];

fn check(bytes: &[u8], what: &str) {
    let (map, report) = read(bytes);
    assert_eq!((map.width(), map.height(), report.format), (16, 8, FileFormat::Radiance), "{what}");
    for y in 0..8 {
        for x in 0..16 {
            assert_eq!(map.pixel(x, y), expected(x), "{what} at ({x}, {y})");
        }
    }
}

fn flat() -> Vec<u8> {
    [[LEFT; 8], [RIGHT; 8]].concat().concat().repeat(8)
}

fn old_rle() -> Vec<u8> {
    [LEFT, [1, 1, 1, 7], RIGHT, [1, 1, 1, 7]].concat().repeat(8)
}

fn new_rle() -> Vec<u8> {
    let run = |value: u8| [128 + 16, value];
    let mut row = [2, 2, 0, 16].to_vec();
    row.extend([run(128), run(64), run(32)].concat());
    row.extend([128 + 8, 129, 8, 131, 131, 131, 131, 131, 131, 131, 131]);
    row.repeat(8)
}

#[test]
fn flat_old_and_new_encodings_are_read() {
    for (what, pixels) in [("flat", flat()), ("old", old_rle()), ("new", new_rle())] {
        check(&file(HEADER, "-Y 8 +X 16", &pixels), what);
        check(&file("#?RGBE\nFORMAT=32-bit_rle_rgbe\n", "-Y 8 +X 16", &pixels), what);
    }
}

#[test]
fn headers_of_windows_are_read_and_texels_that_were_converted_too_are_refused() {
    let header = format!("{HEADER}\n-Y 8 +X 16\n").replace('\n', "\r\n").into_bytes();
    for (what, pixels) in [("flat", flat()), ("old", old_rle()), ("new", new_rle())] {
        check(&[header.as_slice(), &pixels].concat(), what);
    }
    // Texels whose red is the byte of a line end.
    let whole = [header.as_slice(), &[10_u8, 64, 32, 129].repeat(16 * 8)].concat();
    assert_eq!(read(&whole).0.pixel(0, 0)[0], 2.0 * 10.0 / 256.0, "as they were");
    let converted = [header.as_slice(), &[13_u8, 10, 64, 32, 129].repeat(16 * 8)].concat();
    let error = read_picture_bytes(&converted, "test.hdr", &PictureReadOptions::default());
    let Err(ImageError::Invalid { message, .. }) = error else { panic!("converted: {error:?}") };
    assert!(message.contains("sent or saved as text"), "{message}");
}

#[test]
fn the_first_row_of_the_file_is_the_top_of_the_map() {
    let row = |y: u8| [[16 * y + 8, 0, 0, 128]; 16].concat();
    let (map, _) = read(&file(HEADER, "-Y 8 +X 16", &(0..8).flat_map(row).collect::<Vec<_>>()));
    for y in 0..8 {
        assert_eq!(map.pixel(3, y)[0], (16 * y + 8) as f32 / 256.0, "row {y}");
    }
}

#[test]
fn exposure_and_color_correction_are_divided_out_and_noted() {
    let lines =
        format!("{HEADER}EXPOSURE=2\nEXPOSURE=4.0\nCOLORCORR=1 0.5 2\nPRIMARIES=0.7 0.3 0.2 0.7 0.1 0.1 0.3 0.3\n");
    let (map, report) = read(&file(&lines, "-Y 8 +X 16", &flat()));
    let found = map.pixel(0, 0);
    assert_eq!(found, [1.0 / 8.0, 0.5 / 4.0, 0.25 / 16.0], "exposure 8, correction 1 0.5 2");
    assert_eq!(report.notes.len(), 2, "{:?}", report.notes);
    assert!(report.notes[0].contains("EXPOSURE 8") && report.notes[1].contains("PRIMARIES"), "{:?}", report.notes);
}

#[test]
fn header_lines_that_say_nothing_are_not_noted() {
    let lines = format!("{HEADER}EXPOSURE=1\nGAMMA=1\nPIXASPECT=1\nPRIMARIES=0 0 0 0 0 0 0 0\nSOFTWARE=test\n");
    let (_, report) = read(&file(&lines, "-Y 8 +X 16", &flat()));
    assert!(report.notes.is_empty(), "{:?}", report.notes);
}

#[test]
fn impossible_exposures_are_errors() {
    for exposure in ["0", "-1", "inf", "NaN", "1e-45"] {
        let lines = format!("{HEADER}EXPOSURE={exposure}\n");
        let error =
            read_picture_bytes(&file(&lines, "-Y 8 +X 16", &flat()), "test.hdr", &PictureReadOptions::default());
        let message = error.unwrap_err().to_string();
        assert!(message.contains("EXPOSURE"), "{exposure}: {message}");
    }
}

#[test]
fn other_orientations_and_color_spaces_are_refused_by_name() {
    for resolution in ["+Y 8 +X 16", "-Y 8 -X 16", "+X 16 -Y 8", "-X 16 +Y 8"] {
        let error = read_picture_bytes(&file(HEADER, resolution, &flat()), "test.hdr", &PictureReadOptions::default());
        let Err(ImageError::Unsupported { message, .. }) = error else { panic!("{resolution}: {error:?}") };
        let axes: Vec<&str> = resolution.split(' ').step_by(2).collect();
        assert!(message.contains(&axes.join(" ")) && message.contains("-Y h +X w"), "{resolution}: {message}");
        assert!(message.contains("oiiotool"), "{resolution}, what to do: {message}");
    }
    let xyze = file("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n", "-Y 8 +X 16", &flat());
    let error = read_picture_bytes(&xyze, "test.hdr", &PictureReadOptions::default());
    let Err(ImageError::Unsupported { message, .. }) = error else { panic!("XYZE: {error:?}") };
    assert!(message.contains("xyze") && message.contains("ra_xyze -r"), "{message}");
}

#[test]
fn other_primaries_are_noted_or_converted() {
    let lines = format!("{HEADER}PRIMARIES= 0.708 0.292 0.17 0.797 0.131 0.046 0.3127 0.329\n");
    // Gray of ITU-R BT.2020, and its red.
    let bytes = file(&lines, "-Y 1 +X 2", &[128, 128, 128, 129, 128, 0, 0, 129]);
    let (kept, report) = read(&bytes);
    assert_eq!(kept.pixels(), [[1.0; 3], [1.0, 0.0, 0.0]]);
    assert!(report.notes[0].contains("not those of Rec. 709"), "{:?}", report.notes);
    let options = PictureReadOptions::default().to_rec_709(true);
    let (converted, report) = read_picture_bytes(&bytes, "test.hdr", &options).unwrap();
    assert!(report.notes[0].contains("converted"), "{:?}", report.notes);
    // A column of the matrix of ITU-R BT.2087, rounded to four digits.
    for (found, expected) in converted.pixels().iter().zip([[1.0; 3], [1.6605, -0.1246, -0.0182]]) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2e-4), "{found:?} against {expected:?}");
    }
    let unknown = format!("{HEADER}PRIMARIES= 0 0 0 0 0 0 0 0\n");
    let (_, report) = read(&file(&unknown, "-Y 1 +X 2", &[128, 128, 128, 129, 128, 0, 0, 129]));
    assert!(report.notes.is_empty(), "zeros are none: {:?}", report.notes);
}
