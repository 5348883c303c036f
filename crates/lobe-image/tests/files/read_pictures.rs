//! Portable float maps, PNG and JPEG.

use lobe_image::{
    FileFormat, ImageError, Picture, PictureReadOptions, PictureReadReport, Tone, read_picture_bytes, srgb_decode,
};
use png::{BitDepth, ColorType};

fn read(bytes: &[u8]) -> (Picture, PictureReadReport) {
    read_picture_bytes(bytes, "test", &PictureReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// A portable float map with these numbers, the lowest row first.
pub(crate) fn pfm(header: &str, values: &[f32], bytes: fn(f32) -> [u8; 4]) -> Vec<u8> {
    [header.as_bytes(), &values.iter().flat_map(|v| bytes(*v)).collect::<Vec<_>>()].concat()
}

/// A picture of 16 x 8 as a JPEG, of the colors of [`color`].
pub(crate) const JPEG: &[u8] = include_bytes!("../data/color.jpg");

/// The color of a texel of the small pictures: red rises to the right, green downwards.
fn color(x: usize, y: usize) -> [u8; 3] {
    [17 * x as u8, 36 * y as u8, 128]
}

/// A picture of 16 x 8 as a PNG; gray is green.
pub(crate) fn png(kind: ColorType, depth: BitDepth) -> Vec<u8> {
    png_with(kind, depth, |_| {})
}

/// A picture of 16 x 8 as a PNG with further chunks.
fn png_with(kind: ColorType, depth: BitDepth, change: impl FnOnce(&mut png::Encoder<'_, &mut Vec<u8>>)) -> Vec<u8> {
    let texel = |i: usize| {
        let [r, g, b] = color(i % 16, i / 16);
        match kind {
            ColorType::Grayscale => vec![g],
            ColorType::GrayscaleAlpha => vec![g, 255],
            ColorType::Rgb => vec![r, g, b],
            _ => vec![r, g, b, 255],
        }
    };
    let values: Vec<u8> = (0..16 * 8).flat_map(texel).collect();
    // A value of sixteen bits is that of eight, twice.
    let values = if depth == BitDepth::Sixteen { values.iter().flat_map(|v| [*v; 2]).collect() } else { values };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 16, 8);
    encoder.set_color(kind);
    encoder.set_depth(depth);
    change(&mut encoder);
    encoder.write_header().unwrap().write_image_data(&values).unwrap();
    bytes
}

/// Bytes of a PNG before its second chunk: the signature and IHDR.
const HEAD: usize = 8 + 25;

/// A PNG with another chunk behind the first.
fn with_chunk(png: &[u8], kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let named = [kind.as_slice(), data].concat();
    let bit = |crc: u32, _: usize| (crc >> 1) ^ (0xedb88320 * (crc & 1));
    let crc = !named.iter().fold(!0_u32, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), bit));
    let length = data.len() as u32;
    [&png[..HEAD], &length.to_be_bytes(), &named, &crc.to_be_bytes(), &png[HEAD..]].concat()
}

/// The light of a value of eight bits.
fn linear(c: u8) -> f64 {
    let c = f64::from(c) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// The largest error of a channel.
fn error_of(found: [f32; 3], expected: [f64; 3]) -> f64 {
    (0..3).map(|c| (f64::from(found[c]) - expected[c]).abs()).fold(0.0, f64::max)
}

#[test]
fn portable_float_maps_of_both_orders_and_colors_are_read() {
    let values: Vec<f32> = (0..6).map(|i| i as f32 - 0.5).collect();
    let rgb = |i: usize| [values[3 * i], values[3 * i + 1], values[3 * i + 2]];
    for (header, bytes) in
        [("PF\n2 1\n-1.0\n", f32::to_le_bytes as fn(f32) -> [u8; 4]), ("PF 2 1 1\n", f32::to_be_bytes)]
    {
        let (map, report) = read(&pfm(header, &values, bytes));
        assert_eq!(map.pixels(), [rgb(0), rgb(1)], "{header:?}");
        assert_eq!((report.format, report.negative, report.notes.len()), (FileFormat::Pfm, 1, 0), "{header:?}");
    }
    let (gray, _) = read(&pfm("Pf\n4 2\n-1\n", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0], f32::to_le_bytes));
    assert_eq!(gray.pixel(1, 0), [6.0, 6.0, 6.0], "the first row of the file is the lowest");
    assert_eq!(gray.pixel(3, 1), [4.0, 4.0, 4.0], "gray");
}

#[test]
fn the_scale_of_a_portable_float_map_is_a_factor_and_noted() {
    let (map, report) = read(&pfm("PF\n2 1\n-2.5\n", &[1.0; 7], f32::to_le_bytes));
    assert_eq!(map.pixel(0, 0), [2.5, 2.5, 2.5], "multiplied");
    assert!(report.notes[0].contains("2.5") && report.notes[1].contains("4 bytes"), "{:?}", report.notes);
}

#[test]
fn png_and_jpeg_are_decoded_from_srgb() {
    use BitDepth::{Eight, Sixteen};
    // With tolerances: rounding for PNG, the loss of the quality for JPEG.
    let cases: [(&str, Vec<u8>, FileFormat, f64); 6] = [
        ("8 bits", png(ColorType::Rgb, Eight), FileFormat::Png, 1e-7),
        ("8 bits and alpha", png(ColorType::Rgba, Eight), FileFormat::Png, 1e-7),
        ("16 bits", png(ColorType::Rgb, Sixteen), FileFormat::Png, 1e-7),
        ("16 bits and alpha", png(ColorType::Rgba, Sixteen), FileFormat::Png, 1e-7),
        ("JPEG", JPEG.to_vec(), FileFormat::Jpeg, 0.12),
        ("JPEG of inks", include_bytes!("../data/cmyk.jpg").to_vec(), FileFormat::Jpeg, 0.12),
    ];
    for (what, bytes, format, tolerance) in cases {
        let (map, report) = read(&bytes);
        assert_eq!((report.format, map.width(), map.height()), (format, 16, 8), "{what}");
        assert!(
            report.notes[0].contains("sRGB") && report.notes[0].contains("white is 1"),
            "{what}: {:?}",
            report.notes
        );
        assert_eq!(report.notes.len(), 1 + usize::from(what.contains("alpha")), "{what}: {:?}", report.notes);
        for (x, y) in [(0, 0), (15, 0), (0, 7), (9, 4)] {
            let (expected, found) = (color(x, y).map(linear), map.pixel(x, y));
            let error = error_of(found, expected);
            assert!(error < tolerance, "{what} at ({x}, {y}): {found:?} against {expected:?}");
        }
    }
}

/// From a sample to light.
type Decode = fn(f64) -> f64;

#[test]
fn a_png_becomes_light_as_its_chunks_say() {
    for depth in [BitDepth::Eight, BitDepth::Sixteen] {
        let plain = png(ColorType::Rgb, depth);
        let with = |kind: &[u8; 4], data: &[u8]| with_chunk(&plain, kind, data);
        let gamma = |parts: u32| with(b"gAMA", &parts.to_be_bytes());
        let rec_709 = |v: f64| if v < 0.081 { v / 4.5 } else { ((v + 0.099) / 1.099).powf(1.0 / 0.45) };
        let cases: [(Vec<u8>, Decode, &str); 12] = [
            (gamma(100_000), |v| v, "of linear light as the chunk gAMA says"),
            (gamma(50_000), |v| v * v, "decoded by the power 2 as the chunk gAMA says"),
            // 1/2.2 as it is rounded stands for sRGB.
            (gamma(45_455), srgb_decode, "decoded from sRGB"),
            (gamma(45_000), srgb_decode, "decoded from sRGB"),
            (with_chunk(&gamma(100_000), b"sRGB", &[0]), srgb_decode, "decoded from sRGB"),
            (with(b"cICP", &[1, 13, 0, 1]), srgb_decode, "decoded from sRGB"),
            (with(b"cICP", &[1, 8, 0, 1]), |v| v, "of linear light as the chunk cICP says"),
            (with(b"cICP", &[1, 4, 0, 1]), |v| v.powf(2.2), "decoded by the power 2.2 as the chunk cICP says"),
            (with(b"cICP", &[1, 1, 0, 1]), rec_709, "decoded by the curve of Rec. 709 as the chunk cICP says"),
            (with_chunk(&gamma(100_000), b"cICP", &[1, 13, 0, 1]), srgb_decode, "decoded from sRGB"),
            // What cICP leaves open, other chunks say.
            (with_chunk(&gamma(100_000), b"cICP", &[1, 2, 0, 1]), |v| v, "of linear light as the chunk gAMA says"),
            (with(b"cICP", &[2, 2, 0, 1]), srgb_decode, "decoded from sRGB"),
        ];
        for (k, (bytes, light, note)) in cases.into_iter().enumerate() {
            let (map, report) = read(&bytes);
            assert!(report.notes.len() == 1 && report.notes[0].contains(note), "case {k}: {:?}", report.notes);
            for (x, y) in [(0, 0), (15, 0), (0, 7), (9, 4)] {
                let expected = color(x, y).map(|c| light(f64::from(c) / 255.0));
                let error = error_of(map.pixel(x, y), expected);
                assert!(error < 1e-7, "case {k} at ({x}, {y}): {:?} against {expected:?}", map.pixel(x, y));
            }
        }
    }
}

#[test]
fn the_gamma_beside_a_profile_is_ignored_with_it() {
    let linear = with_chunk(&png(ColorType::Rgb, BitDepth::Eight), b"gAMA", &100_000_u32.to_be_bytes());
    // A name, the method of compression, and what no one reads.
    let profile = [&b"name\0\0"[..], &miniz_oxide::deflate::compress_to_vec_zlib(b"profile", 6)].concat();
    let (_, report) = read(&with_chunk(&linear, b"iCCP", &profile));
    assert!(report.notes[0].contains("decoded from sRGB"), "{:?}", report.notes);
    assert!(report.notes[1].contains("the color profile cannot be understood"), "{:?}", report.notes);
}

/// A profile of Display P3 by the power 2.2, whose colors are those of ICC's white D50.
fn profile_of_p3() -> Vec<u8> {
    let columns = [[0.5151, 0.2412, -0.0011], [0.2919, 0.6922, 0.0419], [0.1572, 0.0666, 0.7841]];
    let mut header = vec![0; 128];
    header[16..24].copy_from_slice(b"RGB XYZ ");
    header[36..40].copy_from_slice(b"acsp");
    let start = 128 + 4 + 6 * 12;
    let mut data = Vec::new();
    let mut tags = 6_u32.to_be_bytes().to_vec();
    for (name, column) in [b"rXYZ", b"gXYZ", b"bXYZ"].into_iter().zip(columns) {
        tags.extend([name.as_slice(), &(start + data.len() as u32).to_be_bytes(), &20_u32.to_be_bytes()].concat());
        data.extend(b"XYZ \0\0\0\0");
        data.extend(column.iter().flat_map(|c: &f64| ((c * 65536.0).round() as i32).to_be_bytes()));
    }
    for name in [b"rTRC", b"gTRC", b"bTRC"] {
        tags.extend([name.as_slice(), &(start + data.len() as u32).to_be_bytes(), &14_u32.to_be_bytes()].concat());
    }
    data.extend(b"curv\0\0\0\0\0\0\0\x01\x02\x33");
    [header, tags, data].concat()
}

#[test]
fn color_chunks_of_a_png_hold_in_their_order_each_for_what_it_tells() {
    let rec_2020 = png::SourceChromaticities::new((0.3127, 0.329), (0.708, 0.292), (0.17, 0.797), (0.131, 0.046));
    let plain = png_with(ColorType::Rgb, BitDepth::Sixteen, |encoder| encoder.set_source_chromaticities(rec_2020));
    let with_profile = |png: &[u8], profile: &[u8]| {
        let data = [&b"name\0\0"[..], &miniz_oxide::deflate::compress_to_vec_zlib(profile, 6)].concat();
        with_chunk(png, b"iCCP", &data)
    };
    let [p3, other] = [profile_of_p3(), b"profile".to_vec()];
    let coded = |png: &[u8], primaries: u8, transfer: u8| with_chunk(png, b"cICP", &[primaries, transfer, 0, 1]);
    let by_profile = "decoded by the curve of its color profile";
    for (what, bytes, curve, primaries) in [
        ("a profile before cHRM", with_profile(&plain, &p3), by_profile, "of the color profile are not"),
        ("primaries of cICP", coded(&with_profile(&plain, &p3), 9, 2), by_profile, "of the chunk cICP are not"),
        (
            "transfer of cICP",
            coded(&with_profile(&plain, &p3), 2, 13),
            "decoded from sRGB",
            "of the color profile are not",
        ),
        ("all of cICP", coded(&with_profile(&plain, &other), 9, 13), "decoded from sRGB", "of the chunk cICP are not"),
        (
            "none is understood",
            coded(&with_profile(&plain, &other), 2, 13),
            "decoded from sRGB",
            "the color profile cannot",
        ),
    ] {
        let (_, report) = read(&bytes);
        assert!(report.notes[0].contains(curve), "{what}: {:?}", report.notes);
        assert!(report.notes.len() == 2 && report.notes[1].contains(primaries), "{what}: {:?}", report.notes);
    }
    // The curve of a profile that is not understood is passed over with a note.
    let (_, report) = read(&coded(&with_profile(&plain, &other), 9, 2));
    let assumed = "the color profile is ignored; the curve of sRGB is assumed";
    assert!(report.notes.len() == 3 && report.notes.iter().any(|note| note == assumed), "{:?}", report.notes);
    // What is not understood and not used keeps no picture from being converted.
    let zeros = with_chunk(&png(ColorType::Rgb, BitDepth::Sixteen), b"cHRM", &[0; 32]);
    let options = PictureReadOptions::default().to_rec_709(true);
    assert!(read_picture_bytes(&zeros, "test", &options).is_err(), "cHRM alone");
    let converted = read_picture_bytes(&with_profile(&zeros, &p3), "test", &options);
    assert!(converted.is_ok(), "beside a profile: {:?}", converted.map(|_| ()));
}

#[test]
fn diffuse_white_is_one_by_every_advice() {
    let png = with_chunk(&png(ColorType::Rgb, BitDepth::Sixteen), b"cICP", &[9, 16, 0, 1]);
    for bytes in [&png[..], b"\0\0\0\x20ftypavif\0\0\0\0", b"\0\0\0\x20ftypheic\0\0\0\0"] {
        let error = read_picture_bytes(bytes, "test", &PictureReadOptions::default()).unwrap_err().to_string();
        assert!(error.contains("npl=203,"), "{error}");
    }
}

#[test]
fn light_of_a_png_that_is_not_understood_is_refused_with_what_to_do() {
    let plain = png(ColorType::Rgb, BitDepth::Sixteen);
    let cases: [([u8; 4], [&str; 2]); 4] = [
        ([9, 16, 0, 1], ["PQ", "ffmpeg"]),
        ([9, 18, 0, 1], ["HLG", "ffmpeg"]),
        ([1, 11, 0, 1], ["transfer function 11", "ffmpeg"]),
        ([1, 13, 0, 0], ["narrow range", "save it with full range"]),
    ];
    for (points, parts) in cases {
        let bytes = with_chunk(&plain, b"cICP", &points);
        let error = read_picture_bytes(&bytes, "test", &PictureReadOptions::default());
        let Err(ImageError::Unsupported { message, .. }) = error else { panic!("{points:?}: {error:?}") };
        assert!(parts.iter().all(|part| message.contains(part)), "{points:?}: {parts:?} expected in {message:?}");
    }
}

#[test]
fn primaries_of_a_number_are_those_of_their_coordinates() {
    let rec_2020 = png::SourceChromaticities::new((0.3127, 0.329), (0.708, 0.292), (0.17, 0.797), (0.131, 0.046));
    let plain = png(ColorType::Rgb, BitDepth::Sixteen);
    let by_place = png_with(ColorType::Rgb, BitDepth::Sixteen, |encoder| encoder.set_source_chromaticities(rec_2020));
    let by_number = with_chunk(&plain, b"cICP", &[9, 13, 0, 1]);
    let options = PictureReadOptions::default().to_rec_709(true);
    let converted = |bytes: &[u8]| read_picture_bytes(bytes, "test", &options).unwrap().0;
    let (expected, found) = (converted(&by_place), converted(&by_number));
    for (i, (a, b)) in found.pixels().iter().zip(expected.pixels()).enumerate() {
        // The coordinates of a file are rounded to five digits.
        assert!(error_of(*a, b.map(f64::from)) < 1e-3, "texel {i}: {a:?} against {b:?}");
    }
    let note = |bytes: &[u8]| read(bytes).1.notes[1..].join("; ");
    let kept = "the primaries of the chunk cICP are not those of Rec. 709; the values are taken as they are";
    assert_eq!(note(&by_number), kept, "BT.2020");
    assert_eq!(note(&with_chunk(&by_place, b"cICP", &[1, 13, 0, 1])), "", "cICP holds before cHRM");
    let unknown = "the number 10 of primaries of the chunk cICP cannot be understood; the values are taken as they are";
    assert_eq!(note(&with_chunk(&plain, b"cICP", &[10, 13, 0, 1])), unknown, "XYZ");
}

#[test]
fn photographs_are_turned_as_the_camera_noted() {
    // Where the table of Exif says that row 0 and column 0 of the stored picture are: as sides of the upright one.
    let sides = [
        "top left",
        "top right",
        "bottom right",
        "bottom left",
        "left top",
        "right top",
        "right bottom",
        "left bottom",
    ];
    for (orientation, sides) in (1_u8..).zip(sides) {
        // Exif behind the first marker: one entry, tag 0x112, a short.
        let mut bytes = JPEG.to_vec();
        let mut exif = b"\xff\xe1\0\x22Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01".to_vec();
        exif.extend([0, orientation, 0, 0, 0, 0, 0, 0]);
        bytes.splice(2..2, exif);
        let (map, report) = read(&bytes);
        assert_eq!(report.notes.len(), 1 + usize::from(orientation > 1), "{orientation}: {:?}", report.notes);
        let (width, height) = if orientation > 4 { (8, 16) } else { (16, 8) };
        assert_eq!((map.width(), map.height()), (width, height), "orientation {orientation}");
        let (row_side, column_side) = sides.split_once(' ').unwrap();
        // The distance of an upright texel from a side.
        let from = |side: &str, x: usize, y: usize| match side {
            "top" => y,
            "bottom" => height - 1 - y,
            "left" => x,
            _ => width - 1 - x,
        };
        for (x, y) in [(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1), (5, 2)] {
            let (found, expected) = (map.pixel(x, y), color(from(column_side, x, y), from(row_side, x, y)).map(linear));
            let error = error_of(found, expected);
            assert!(error < 0.12, "orientation {orientation} at ({x}, {y}): {found:?} against {expected:?}");
        }
    }
}

#[test]
fn other_primaries_are_noted_or_converted() {
    let rec_2020 = png::SourceChromaticities::new((0.3127, 0.329), (0.708, 0.292), (0.17, 0.797), (0.131, 0.046));
    let bytes = png_with(ColorType::Rgb, BitDepth::Sixteen, |encoder| encoder.set_source_chromaticities(rec_2020));
    let (kept, report) = read(&bytes);
    assert!(report.notes[1].contains("cHRM are not those of Rec. 709"), "{:?}", report.notes);
    let options = PictureReadOptions::default().to_rec_709(true);
    let (converted, report) = read_picture_bytes(&bytes, "test", &options).unwrap();
    assert!(report.notes[1].contains("converted"), "{:?}", report.notes);
    // ITU-R BT.2087, rounded to four digits.
    let matrix = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
    for (x, y) in [(0, 0), (15, 0), (0, 7), (9, 4)] {
        let color = kept.pixel(x, y).map(f64::from);
        let expected = matrix.map(|row: [f64; 3]| row[0] * color[0] + row[1] * color[1] + row[2] * color[2]);
        let error = error_of(converted.pixel(x, y), expected);
        assert!(error < 2e-4, "({x}, {y}): {:?} against {expected:?}", converted.pixel(x, y));
    }
    assert!(report.negative > 0, "saturated colors lie outside of Rec. 709");
    let (_, report) = read(&png(ColorType::Rgb, BitDepth::Sixteen));
    assert_eq!(report.notes.len(), 1, "without primaries there is nothing to say: {:?}", report.notes);
}

#[test]
fn gray_pictures_are_read() {
    for (what, bytes) in [
        ("8 bits", png(ColorType::Grayscale, BitDepth::Eight)),
        ("16 bits", png(ColorType::Grayscale, BitDepth::Sixteen)),
        ("alpha", png(ColorType::GrayscaleAlpha, BitDepth::Eight)),
        ("JPEG", include_bytes!("../data/gray.jpg").to_vec()),
    ] {
        let (map, _) = read(&bytes);
        let texel = map.pixel(12, 6);
        assert!(texel[0] == texel[1] && texel[1] == texel[2] && texel[1] > 0.1, "{what}: {texel:?}");
        assert!(map.pixel(0, 0)[0] < texel[0], "{what}: dark at the top left");
    }
}

#[test]
fn pictures_of_any_shape_are_read_when_asked_for() {
    let stored = Picture::from_fn(3, 5, |x, y| [f32::from(u8::from(x == 2 && y == 1)), 0.0, 1.0]);
    let (picture, report) = read(&stored.to_png(&Tone::PLAIN).unwrap());
    assert_eq!((picture.width(), picture.height(), report.levels), (3, 5, 1), "size");
    assert_eq!((picture.pixel(2, 1), picture.pixel(1, 1)), ([1.0, 0.0, 1.0], [0.0, 0.0, 1.0]), "texels in rows");
}
