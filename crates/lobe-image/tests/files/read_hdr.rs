//! Radiance files of every kind that Lobe reads or refuses.

use std::io::Cursor;

use lobe_image::{
    FileFormat, ImageError, Picture, PictureReadOptions, PictureReadReport, PictureRows, ReadOption, read_picture_bytes,
};

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
    for exposure in ["-1", "inf", "NaN", "1e-45"] {
        let lines = format!("{HEADER}EXPOSURE={exposure}\n");
        let error =
            read_picture_bytes(&file(&lines, "-Y 8 +X 16", &flat()), "test.hdr", &PictureReadOptions::default());
        let message = error.unwrap_err().to_string();
        assert!(message.contains("EXPOSURE"), "{exposure}: {message}");
    }
}

#[test]
fn a_picture_is_upright_whichever_way_its_scan_lines_go() {
    // Each texel is its own: red counts columns, green rows.
    let (width, height) = (9_u8, 5_u8);
    let upright: Vec<[f32; 3]> =
        (0..height).flat_map(|y| (0..width).map(move |x| [f32::from(x), f32::from(y), 9.0])).collect();
    let forth_and_back = |count: u8, is_forth: bool| -> Vec<u8> {
        if is_forth { (0..count).collect() } else { (0..count).rev().collect() }
    };
    for first in ["-Y", "+Y", "-X", "+X"] {
        for second in if first.ends_with('Y') { ["-X", "+X"] } else { ["-Y", "+Y"] } {
            let [columns, rows] = ["X", "Y"].map(|axis| {
                let is_forth = [first, second].contains(&if axis == "X" { "+X" } else { "-Y" });
                forth_and_back(if axis == "X" { width } else { height }, is_forth)
            });
            // 2^e / 256 is 1 at e = 136.
            let texel = |x: u8, y: u8| [x, y, 9, 136];
            let (resolution, pixels): (_, Vec<u8>) = if first.ends_with('Y') {
                let pixels = rows.iter().flat_map(|y| columns.iter().flat_map(move |x| texel(*x, *y))).collect();
                (format!("{first} {height} {second} {width}"), pixels)
            } else {
                let pixels = columns.iter().flat_map(|x| rows.iter().flat_map(move |y| texel(*x, *y))).collect();
                (format!("{first} {width} {second} {height}"), pixels)
            };
            let bytes = file(HEADER, &resolution, &pixels);
            let (picture, report) = read(&bytes);
            assert_eq!((picture.width(), picture.height()), (9, 5), "{resolution}");
            assert_eq!(picture.pixels(), upright, "{resolution}");
            assert!(report.notes.is_empty(), "{resolution}: {:?}", report.notes);
            let rows = PictureRows::new(Cursor::new(&bytes), "test.hdr", &PictureReadOptions::default()).unwrap();
            assert_eq!(rows.is_some(), resolution == "-Y 5 +X 9", "{resolution}: rows from the top only");
        }
    }
    for no_axes in ["-Y 8 +Y 16", "+Z 8 +X 16", "Y 8 X 16"] {
        let error = read_picture_bytes(&file(HEADER, no_axes, &flat()), "test.hdr", &PictureReadOptions::default());
        assert!(matches!(error, Err(ImageError::Invalid { .. })), "{no_axes}: {error:?}");
    }
}

#[test]
fn colors_in_xyz_are_those_that_radiance_makes_of_them() {
    // White of equal energy, 179 lumens in a watt: 179 = 179/256 2^8.
    let header = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n";
    let (picture, report) = read(&file(header, "-Y 1 +X 1", &[179, 179, 179, 136]));
    for c in picture.pixel(0, 0) {
        assert!((c - 1.0).abs() < 1e-6, "white: {:?}", picture.pixel(0, 0));
    }
    assert!(report.notes[0].contains("XYZ") && report.notes[0].contains("179"), "{:?}", report.notes);
    // XYZ of Radiance's red, x 0.64, y 0.33, of luminance 1/4: its share of white is 0.265.
    let stored = [179.0 * 0.25 * 0.64 / 0.33, 179.0 * 0.25, 179.0 * 0.25 * 0.03 / 0.33].map(|c: f32| c.round() as u8);
    let (picture, _) = read(&file(header, "-Y 1 +X 1", &[stored[0], stored[1], stored[2], 136]));
    let [r, g, b] = picture.pixel(0, 0);
    assert!((r - 0.25 / 0.265).abs() < 0.01 && g.abs() < 0.01 && b.abs() < 0.01, "red: {r} {g} {b}");
    // As ra_xyze writes it: values as before, the lumens in the exposure.
    let header = format!("{header}EXPOSURE=5.586592e-03\n");
    let (picture, _) = read(&file(&header, "-Y 1 +X 1", &[128, 128, 128, 129]));
    assert!(picture.pixel(0, 0).iter().all(|c| (c - 1.0).abs() < 1e-5), "with exposure: {:?}", picture.pixel(0, 0));
}

#[test]
fn indented_lines_are_the_history_of_a_picture_and_change_nothing() {
    for history in [
        "\tEXPOSURE=9",
        " EXPOSURE=9",
        "\tCOLORCORR=2 2 2",
        "\tPRIMARIES=0.7 0.3 0.2 0.7 0.1 0.05 0.31 0.33",
        "\tFORMAT=32-bit_rle_xyze",
        "\t\tEXPOSURE=0",
        "\tPIXASPECT=2",
        "\tlobe-mapping=angular",
        "pfilt -1 EXPOSURE=9 a.hdr",
    ] {
        for lines in
            [format!("{HEADER}{history}\n"), format!("#?RADIANCE\na.hdr:\n{history}\nFORMAT=32-bit_rle_rgbe\n")]
        {
            let bytes = file(&lines, "-Y 8 +X 16", &flat());
            check(&bytes, history);
            let (_, report) = read(&bytes);
            assert!(report.notes.is_empty() && report.mapping.is_none(), "{history}: {report:?}");
        }
    }
}

#[test]
fn values_that_are_no_numbers_are_noted_and_change_nothing() {
    for line in [
        "EXPOSURE=2,5",
        "EXPOSURE=auto",
        "EXPOSURE=",
        "EXPOSURE=2 3",
        "COLORCORR=1 2",
        "COLORCORR=1,2,3",
        "GAMMA=x",
        "Exposure=2",
        "VIEW= -vta -vh 180",
        "EXPOSURE=0",
        "COLORCORR=0 0 0",
    ] {
        let bytes = file(&format!("{HEADER}{line}\n"), "-Y 8 +X 16", &flat());
        check(&bytes, line);
        let (_, report) = read(&bytes);
        let [note] = &report.notes[..] else { panic!("{line}: {:?}", report.notes) };
        let (key, value) = line.split_once('=').unwrap();
        assert!(note.contains(&format!("{key}={}", value.trim())), "{line}: {note}");
    }
}

#[test]
fn a_header_that_says_a_thing_many_times_or_at_length_gets_one_short_note_of_it() {
    let long = "x".repeat(1 << 19);
    for (lines, part) in [
        ("VIEW=a\n".repeat(90_000), "VIEW (90000 lines) of the header is ignored"),
        ("EXPOSURE=0\n".repeat(3), "EXPOSURE (3 lines) of the header is read as 1"),
        ("COLORCORR=x\n".repeat(2), "COLORCORR (2 lines) of the header is not 3 numbers, and is ignored"),
        (format!("VIEW={long}\n"), "VIEW=xxx"),
        (format!("PRIMARIES={long}\n"), "PRIMARIES=xxx"),
    ] {
        let (_, report) = read(&file(&format!("{HEADER}{lines}"), "-Y 8 +X 16", &flat()));
        let [note] = &report.notes[..] else { panic!("{} notes", report.notes.len()) };
        assert!(note.contains(part) && note.len() < 400, "{part}: {} bytes, {:.80}", note.len(), note);
    }
    let bytes = file(&format!("{HEADER}PRIMARIES={long}\n"), "-Y 8 +X 16", &flat());
    let refused = read_picture_bytes(&bytes, "test.hdr", &PictureReadOptions::default().to_rec_709(true));
    let message = refused.unwrap_err().to_string();
    assert!(message.len() < 500 && message.contains("so the colors cannot be converted"), "{message:.80}");
    // Any letters make a key of its own.
    let keys = (0..64_u32).map(|k| {
        let letter = |(i, c): (u32, char)| if k >> i & 1 == 1 { c.to_ascii_lowercase() } else { c };
        (0..).zip("EXPOSURE".chars()).map(letter).collect::<String>() + "=2\n"
    });
    let (_, report) = read(&file(&format!("{HEADER}{}", keys.collect::<String>()), "-Y 8 +X 16", &flat()));
    assert!(report.notes.len() < 40, "{} notes", report.notes.len());
    assert!(report.notes.last().is_some_and(|note| note.contains("more remarks")), "{:?}", report.notes.last());
}

#[test]
fn pictures_of_other_formats_are_refused_with_a_program_that_reads_them() {
    for (format, part) in [
        ("Radiance_spectra", "FORMAT=Radiance_spectra; convert it with rcomb -C RGB -fc IN.hsr > OUT.hdr"),
        ("32-bit_rle_XYZE", "FORMAT=32-bit_rle_XYZE; convert it with ra_xyze -r"),
        ("ascii", "FORMAT=ascii"),
    ] {
        let bytes = file(&format!("#?RADIANCE\nFORMAT={format}\n"), "-Y 8 +X 16", &flat());
        let error = read_picture_bytes(&bytes, "test.hdr", &PictureReadOptions::default()).unwrap_err().to_string();
        assert!(error.contains(part), "{format}: {error}");
        assert_eq!(error.contains("convert it"), format != "ascii", "{format}: {error}");
    }
}

#[test]
fn primaries_that_cannot_be_understood_are_noted_and_refused_where_they_were_to_be_converted() {
    let seven = "PRIMARIES=0.708 0.292 0.17 0.797 0.131 0.046 0.3127";
    let commas = "PRIMARIES=0.708,0.292,0.17,0.797,0.131,0.046,0.3127,0.329";
    for line in [seven, commas, "PRIMARIES=Rec2020", "PRIMARIES=1 1 1 1 1 1 1 1"] {
        let bytes = file(&format!("{HEADER}{line}\n"), "-Y 8 +X 16", &flat());
        check(&bytes, line);
        let (_, report) = read(&bytes);
        assert!(report.notes.len() == 1 && report.notes[0].contains(line), "{line}: {:?}", report.notes);
        let error = read_picture_bytes(&bytes, "test.hdr", &PictureReadOptions::default().to_rec_709(true));
        let Err(ImageError::Refused { option: ReadOption::ToRec709, message, .. }) = error else {
            panic!("{line}: {error:?}")
        };
        assert!(message.contains(line), "{line}: {message}");
    }
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
