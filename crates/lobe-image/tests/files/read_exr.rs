//! OpenEXR files of every kind that Lobe reads or refuses.

use exr::prelude::*;
use lobe_image::{
    FileFormat, ImageError, Picture, PictureReadOptions, PictureReadReport, ReadOption, read_picture_bytes,
};

use crate::exr_files::{
    Part, SCAN_LINES, exr_file, exr_picture, exr_with_attributes, exr_with_chromaticities, exr_with_mip_levels, planes,
    rgb_part, value,
};

const SIZE: (usize, usize) = (48, 24);

fn read(bytes: &[u8]) -> (Picture, PictureReadReport) {
    read_picture_bytes(bytes, "test.exr", &PictureReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn refusal(bytes: &[u8]) -> String {
    match read_picture_bytes(bytes, "test.exr", &PictureReadOptions::default()) {
        Err(error @ ImageError::Unsupported { .. }) => error.to_string(),
        other => panic!("Unsupported expected, found {other:?}"),
    }
}

/// The largest difference from the test picture, relative to the value.
fn error_of(map: &Picture, channels: [usize; 3]) -> f32 {
    assert_eq!((map.width(), map.height()), SIZE, "size");
    let mut largest = 0.0_f32;
    for y in 0..map.height() {
        for x in 0..map.width() {
            for (found, c) in map.pixel(x, y).into_iter().zip(channels) {
                largest = largest.max((found / value(c, x, y) - 1.0).abs());
            }
        }
    }
    largest
}

#[test]
fn every_compression_is_read_from_scan_lines_and_from_tiles() {
    let compressions = [
        (Compression::Uncompressed, 0.0, 0.0),
        (Compression::RLE, 0.0, 0.0),
        (Compression::ZIP1, 0.0, 0.0),
        (Compression::ZIP16, 0.0, 0.0),
        (Compression::PIZ, 0.0, 0.0),
        // PXR24 keeps 24 bits of a float, B44 six bits of the difference of halves in a block of 4 x 4.
        (Compression::PXR24, 0.0, 1e-4),
        (Compression::B44, 0.05, 0.0),
        (Compression::B44A, 0.05, 0.0),
    ];
    for (compression, half_limit, float_limit) in compressions {
        for (sample_type, limit) in [(SampleType::F16, half_limit), (SampleType::F32, float_limit)] {
            for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 16)), Blocks::Tiles(Vec2(64, 7))] {
                let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
                let (map, report) = read(&exr_picture(SIZE, encoding, planes(&["R", "G", "B"], sample_type, SIZE)));
                let error = error_of(&map, [0, 1, 2]);
                assert!(error <= limit, "{compression:?}, {sample_type:?}, {blocks:?}: {error}");
                assert_eq!(report.format, FileFormat::OpenExr, "{compression:?}");
                assert!(report.notes.is_empty(), "{compression:?}: {:?}", report.notes);
            }
        }
    }
}

#[test]
fn dwaa_and_dwab_are_read_as_openexr_itself_reads_them() {
    let (expected, _) = read(include_bytes!("../data/dwa-decoded.exr"));
    let files: [(&str, &[u8]); 2] =
        [("dwaa", include_bytes!("../data/dwaa.exr")), ("dwab", include_bytes!("../data/dwab.exr"))];
    for (name, bytes) in files {
        let (map, _) = read(bytes);
        let luminance = |[r, g, b]: &[f32; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let brightest = expected.pixels().iter().map(luminance).fold(0.0, f32::max);
        for (i, (a, b)) in map.pixels().iter().zip(expected.pixels()).enumerate() {
            // Both decoders round the same DCT to half.
            let (of_a, of_b) = (luminance(a), luminance(b));
            let error = (of_a - of_b).abs();
            assert!(error <= 2e-3 * of_b + 1e-5 * brightest, "{name}, texel {i}: {a:?} against {b:?}");
        }
    }
}

#[test]
fn luminance_alpha_layers_and_mixed_types_are_read() {
    let cases: [(&[&str], [usize; 3], &str); 7] = [
        (&["R", "G", "B"], [0, 1, 2], ""),
        (&["R", "G", "B", "A"], [0, 1, 2], "alpha is ignored"),
        (&["Y"], [0, 0, 0], "channels Y are read"),
        (&["Y", "A"], [0, 0, 0], "channels Y are read; alpha is ignored"),
        (&["beauty.R", "beauty.G", "beauty.B"], [0, 1, 2], "channels beauty.R, beauty.G, beauty.B are read"),
        (&["R", "G", "B", "x.R", "x.G", "x.B"], [0, 1, 2], "layers that are not read: x"),
        (
            &["a.R", "a.G", "b.c.R", "b.c.G", "b.c.B", "Z"],
            [2, 3, 4],
            "channels b.c.R, b.c.G, b.c.B are read; layers that are not read: a",
        ),
    ];
    for (names, channels, notes) in cases {
        let (map, report) = read(&exr_picture(SIZE, SCAN_LINES, planes(names, SampleType::F16, SIZE)));
        assert_eq!(error_of(&map, channels), 0.0, "{names:?}");
        assert_eq!(report.notes.join("; "), notes, "{names:?}");
    }
    let mut mixed = planes(&["R", "G", "B", "id"], SampleType::F16, SIZE);
    mixed[1].sample_type = SampleType::F32;
    mixed[3].sample_type = SampleType::U32;
    let (map, _) = read(&exr_picture(SIZE, SCAN_LINES, mixed));
    assert_eq!(error_of(&map, [0, 1, 2]), 0.0, "half and float mixed, with an integer channel beside them");
}

#[test]
fn what_has_no_color_that_lobe_reads_is_refused_by_name() {
    let cases: [(&[&str], SampleType, &str); 4] = [
        (&["Z", "depth.V"], SampleType::F32, "found Z, depth.V"),
        (&["R"], SampleType::F16, "found R"),
        (&["Y", "RY", "BY"], SampleType::F16, "luminance-chroma"),
        (&["R", "G", "B"], SampleType::U32, "holds integers"),
    ];
    for (names, sample_type, expected) in cases {
        let message = refusal(&exr_picture(SIZE, SCAN_LINES, planes(names, sample_type, SIZE)));
        assert!(message.contains(expected), "{names:?}: {message}");
    }
    let mut deep = exr_picture(SIZE, SCAN_LINES, planes(&["R", "G", "B"], SampleType::F16, SIZE));
    deep[5] |= 0x08;
    assert!(refusal(&deep).contains("deep data"), "{}", refusal(&deep));
    let htj2k = refusal(include_bytes!("../data/htj2k.exr"));
    assert!(htj2k.contains("HTJ2K"), "{htj2k}");
}

#[test]
fn the_map_is_the_display_window_and_black_outside_the_data_window() {
    let windows = [
        ((0, 0), SIZE),
        ((5, 3), (20, 10)),
        ((-7, -9), (60, 40)),
        ((40, -4), (20, 12)),
        ((-10, 20), (30, 30)),
        ((47, 23), (1, 1)),
        ((-30, 0), (10, 24)),
    ];
    for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(8, 8))] {
        for (position, size) in windows {
            let planes = planes(&["R", "G", "B"], SampleType::F16, size);
            let encoding = Encoding { blocks, ..SCAN_LINES };
            let (map, report) = read(&exr_file(SIZE, vec![Part { name: "a", encoding, position, size, planes }]));
            for y in 0..SIZE.1 {
                for x in 0..SIZE.0 {
                    let (u, v) = (x as i32 - position.0, y as i32 - position.1);
                    let inside = (0..size.0 as i32).contains(&u) && (0..size.1 as i32).contains(&v);
                    let expected = if inside { value(1, u as usize, v as usize) } else { 0.0 };
                    assert_eq!(map.pixel(x, y)[1], expected, "{position:?} {size:?} at ({x}, {y})");
                }
            }
            let noted = report.notes.iter().any(|n| n.contains("data window"));
            assert_eq!(noted, (position, size) != ((0, 0), SIZE), "{position:?} {size:?}: {:?}", report.notes);
        }
    }
}

#[test]
fn a_data_window_or_a_block_above_the_limit_is_refused_with_the_option_that_raises_it() {
    let refused = |bytes: &[u8], max_texels: usize, part: &str| {
        let read = |limit: usize| read_picture_bytes(bytes, "a", &PictureReadOptions::default().max_texels(limit));
        match read(max_texels) {
            Err(ImageError::Refused { message, option: ReadOption::MaxTexels, .. }) => {
                assert!(message.contains(part), "{part:?} expected in {message:?}");
            }
            other => panic!("{part}: Refused expected, found {other:?}"),
        }
        assert!(read(60 * 40).is_ok(), "{part}: with a higher limit");
    };
    let planes_of_60_x_40 = planes(&["R", "G", "B"], SampleType::F16, (60, 40));
    let part = Part { name: "a", encoding: SCAN_LINES, position: (0, 0), size: (60, 40), planes: planes_of_60_x_40 };
    refused(&exr_file(SIZE, vec![part]), SIZE.0 * SIZE.1, "data window is 60 x 40");
    // Eight texels of nine channels of four bytes.
    let many = planes(&["B", "G", "R", "a", "b", "c", "d", "e", "f"], SampleType::F32, (8, 1));
    refused(&exr_picture((8, 1), SCAN_LINES, many), 8, "a block holds 288 bytes");
}

#[test]
fn texels_that_are_not_square_are_noted() {
    let mut bytes = exr_picture(SIZE, SCAN_LINES, planes(&["R", "G", "B"], SampleType::F16, SIZE));
    let key = b"pixelAspectRatio\0float\0\x04\0\0\0";
    let at = bytes.windows(key.len()).position(|window| window == key).unwrap() + key.len();
    bytes[at..at + 4].copy_from_slice(&2_f32.to_le_bytes());
    assert_eq!(read(&bytes).1.notes, ["pixelAspectRatio=2 of the header is ignored"], "notes");
}

#[test]
fn the_largest_mip_level_is_read() {
    let (map, _) = read(&exr_with_mip_levels(SIZE));
    assert_eq!(error_of(&map, [0, 1, 2]), 0.0, "mip levels");
}

#[test]
fn the_first_part_with_color_is_read() {
    let depth = Part { name: "depth", planes: planes(&["Z"], SampleType::F32, SIZE), ..rgb_part(SIZE) };
    let mut other = rgb_part(SIZE);
    other.name = "other";
    other.planes.iter_mut().for_each(|p| p.values.fill(0.0));
    let (map, report) = read(&exr_file(SIZE, vec![depth, rgb_part(SIZE), other]));
    assert_eq!(error_of(&map, [0, 1, 2]), 0.0, "multi-part");
    assert_eq!(report.notes, ["part 1 (\"color\") of 3 is read"], "notes");
}

#[test]
fn other_chromaticities_are_noted_or_converted() {
    let bytes = exr_with_chromaticities([[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], [0.3127, 0.329]]);
    let (kept, report) = read(&bytes);
    let is_noted = |text: &str, notes: &[String]| notes.iter().any(|note| note.contains(text));
    assert!(is_noted("chromaticities are not those of Rec. 709", &report.notes), "{:?}", report.notes);
    let options = PictureReadOptions::default().to_rec_709(true);
    let (converted, report) = read_picture_bytes(&bytes, "test", &options).unwrap();
    assert!(is_noted("converted", &report.notes), "{:?}", report.notes);
    // ITU-R BT.2087, rounded to four digits.
    let matrix = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
    for (color, found) in kept.pixels().iter().zip(converted.pixels()) {
        let expected = matrix.map(|row: [f32; 3]| row[0] * color[0] + row[1] * color[1] + row[2] * color[2]);
        let largest = color.iter().fold(0.0_f32, |a, b| a.max(b.abs()));
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 2e-4 * largest, "{color:?}: {found:?} against {expected:?}");
        }
    }
    let rec_709 = exr_with_chromaticities([[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]]);
    assert!(!is_noted("chromaticities", &read(&rec_709).1.notes), "those of Rec. 709 go without saying");
}

#[test]
fn what_a_header_says_of_the_light_and_other_layers_of_light_are_noted() {
    let channels = planes(&["R", "G", "B", "spec.R", "spec.G", "spec.B", "normal.R", "left.Y"], SampleType::F16, SIZE);
    let plain = read(&exr_picture(SIZE, SCAN_LINES, channels)).1;
    assert_eq!(plain.notes, ["layers that are not read: left, spec"], "layers");
    let spaces =
        [("colorInteropID", "lin_rec709_scene"), ("oiio:ColorSpace", "Linear Rec.2020"), ("colorspace", "ARRI LogC")];
    let bytes = exr_with_attributes(SIZE, |attributes| {
        attributes.white_luminance = Some(100.0);
        attributes.multi_view_names = Some(vec!["left".into(), "right".into()]);
        attributes.other.extend(spaces.map(|(key, value)| (key.into(), AttributeValue::Text(value.into()))));
    });
    let mut notes = read(&bytes).1.notes;
    notes.sort();
    let expected = [
        "colorspace=ARRI LogC of the header is not used: values are taken as linear light of Rec. 709",
        "of the views left, right one is read, left",
        "oiio:ColorSpace=Linear Rec.2020 of the header is not used: values are taken as linear light of Rec. 709",
        "whiteLuminance=100 of the header is not used: a value is taken as radiance",
    ];
    assert_eq!(notes, expected, "attributes");
}
