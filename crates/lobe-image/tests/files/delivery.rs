//! Pictures brighter than white in the formats that they are delivered in: gain maps in JPEG, floating-point TIFF, JPEG XL.
//!
//! The files were written by the encoders of others, see `data/delivery.py`.

use lobe_image::{FileFormat, ImageError, Picture, PictureReadOptions, PictureReadReport, read_picture_bytes};

use crate::read_pictures::JPEG;

const ULTRA_HDR: &[u8] = include_bytes!("../data/ultra-hdr.jpg");
const GRAY: &[u8] = include_bytes!("../data/gray.jpg");

fn read(bytes: &[u8]) -> (Picture, PictureReadReport) {
    read_picture_bytes(bytes, "test", &PictureReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn refusal(bytes: &[u8]) -> ImageError {
    read_picture_bytes(bytes, "test", &PictureReadOptions::default()).map(|_| ()).unwrap_err()
}

/// The light of `data/delivery.py`: without the lamp, and with it.
fn light(column: usize, row: usize) -> [[f64; 3]; 2] {
    let (x, y) = (column as f64, row as f64);
    let dim = [0.0625 + x / 64.0, 0.0625 + y / 32.0, 0.25];
    let lamp = (-((x - 10.0).powi(2) + (y - 5.0).powi(2)) / 8.0).exp();
    [dim, [dim[0] + 6.0 * lamp, dim[1] + 5.0 * lamp, dim[2] + 3.0 * lamp]]
}

/// The largest difference of a channel between a picture and the light of its texels, over that light.
fn relative_error(picture: &Picture, expected: impl Fn(usize, usize) -> [f64; 3]) -> f64 {
    let texels = (0..picture.height()).flat_map(|row| (0..picture.width()).map(move |column| (column, row)));
    let of_texel = |(column, row)| {
        let (found, expected) = (picture.pixel(column, row), expected(column, row));
        (0..3).map(|c| (f64::from(found[c]) - expected[c]).abs() / expected[c]).fold(0.0, f64::max)
    };
    texels.map(of_texel).fold(0.0, f64::max)
}

#[test]
fn tiffs_of_floating_point_numbers_are_read_with_all_of_their_light() {
    // With the rounding of their numbers: of f32, and of f16.
    let (single, half) = (1e-6, 5e-4);
    for (name, bytes, rounding) in [
        ("LZW with a predictor", include_bytes!("../data/lzw.tif").as_slice(), single),
        ("tiles of half floats and alpha, Deflate", include_bytes!("../data/tiled.tif"), half),
        ("planes, 64-bit offsets, big endian", include_bytes!("../data/planes.tif"), single),
        ("gray of doubles", include_bytes!("../data/gray.tif"), single),
    ] {
        let (picture, report) = read(bytes);
        assert_eq!((report.format, picture.width(), picture.height()), (FileFormat::Tiff, 32, 16), "{name}");
        let error = relative_error(&picture, |column, row| {
            let [_, lit] = light(column, row);
            if name.starts_with("gray") { [lit[0]; 3] } else { lit }
        });
        assert!(error < rounding, "{name}: {error}");
        let notes = if name.contains("alpha") { vec!["alpha is ignored"] } else { vec![] };
        assert_eq!(report.notes, notes, "{name}");
        for length in [4, 100, bytes.len() / 2, bytes.len() - 16] {
            let error = refusal(&bytes[..length]);
            assert!(matches!(error, ImageError::Invalid { .. }), "{name}, {length} bytes: {error}");
        }
    }
}

#[test]
fn a_tiff_of_eight_bits_is_decoded_from_srgb_and_says_so() {
    let (picture, report) = read(include_bytes!("../data/display.tif"));
    // Half of a step of 255 is 2.6 % of a value of 1/16 as light by sRGB's curve.
    let linear = |v: f64| if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
    let error = relative_error(&picture, |column, row| light(column, row)[0].map(linear));
    assert!(error < 0.1, "{error}");
    assert!(report.notes[0].contains("cut off"), "{:?}", report.notes);
}

/// A value of `data/delivery.py` in Rec. 2020, six times white and more, as Rec. 709: the matrix of ITU-R BT.2087 to four digits.
fn from_rec_2020([r, g, b]: [f64; 3]) -> [f64; 3] {
    [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]]
        .map(|[x, y, z]| x * r + y * g + z * b)
}

/// A file in Rec. 2020 is taken as it is with a note, and converted where that is asked for; nothing is cut.
fn has_the_primaries_of_rec_2020(bytes: &[u8], what: &str) {
    let wide = |column, row| light(column, row)[1].map(|c| c + 5.0);
    let (picture, report) = read(bytes);
    let error = relative_error(&picture, wide);
    assert!(error < 1e-6, "{what}: {error}");
    assert!(report.notes.len() == 1 && report.notes[0].contains("are not those of Rec. 709"), "{:?}", report.notes);
    let options = PictureReadOptions::default().to_rec_709(true);
    let (picture, _) = read_picture_bytes(bytes, "test", &options).unwrap();
    // The digits of the matrix, and those of the chromaticities in a file.
    let error = relative_error(&picture, |column, row| from_rec_2020(wide(column, row)));
    assert!(error < 1e-3, "{what}, converted: {error}");
}

#[test]
fn colors_of_a_tiff_are_those_that_its_tags_or_its_profile_tell() {
    has_the_primaries_of_rec_2020(include_bytes!("../data/wide.tif"), "TIFF");
    let (picture, report) = read(include_bytes!("../data/adobe.tif"));
    // Adobe RGB has the power 563/256.
    let expected = (128.0_f64 / 255.0).powf(563.0 / 256.0);
    let error = relative_error(&picture, |_, _| [expected; 3]);
    assert!(error < 1e-5, "{error}");
    assert!(report.notes[0].contains("decoded by the curve of its color profile"), "{:?}", report.notes);
    assert!(report.notes[1].contains("the primaries of the color profile are not"), "{:?}", report.notes);
}

#[test]
fn a_raw_photograph_is_refused_rather_than_read_as_its_thumbnail() {
    let error = refusal(include_bytes!("../data/raw.tif")).to_string();
    assert!(error.contains("thumbnail") && error.contains("dcraw"), "{error}");
}

#[test]
fn profiles_that_are_not_understood_are_refused_where_colors_are_to_be_converted() {
    let mut tiff = include_bytes!("../data/adobe.tif").to_vec();
    let at = tiff.windows(4).position(|four| four == b"acsp").unwrap();
    tiff[at] = b'x';
    let notes = read(&tiff).1.notes;
    assert!(notes[1].contains("the color profile cannot be understood"), "{notes:?}");
    let options = PictureReadOptions::default().to_rec_709(true);
    let error = read_picture_bytes(&tiff, "test", &options).unwrap_err();
    assert!(matches!(error, ImageError::Refused { .. }), "{error}");
}

/// What libultrahdr 1.4.0 decodes at these columns and rows.
const DECODED: [(usize, usize, [f64; 3]); 5] = [
    (0, 0, [0.064697265625, 0.061065673828125, 0.255615234375]),
    (10, 5, [6.21484375, 5.21484375, 3.369140625]),
    (13, 5, [2.181640625, 1.8271484375, 1.1884765625]),
    (20, 12, [0.383544921875, 0.438720703125, 0.250732421875]),
    (31, 15, [0.537109375, 0.525390625, 0.2469482421875]),
];

/// Two decoders of JPEG may differ by a step of 255 in each of the two pictures, which is 2 % of the light here.
const STEP: f64 = 0.02;

#[test]
fn an_ultra_hdr_jpeg_has_the_light_that_its_own_library_decodes() {
    // Its profile says Display P3, and the library decodes to Rec. 709.
    let options = PictureReadOptions::default().to_rec_709(true);
    let (picture, report) = read_picture_bytes(ULTRA_HDR, "test", &options).unwrap();
    for (column, row, expected) in DECODED {
        let found = picture.pixel(column, row);
        let error = (0..3).map(|c| (f64::from(found[c]) / expected[c] - 1.0).abs()).fold(0.0, f64::max);
        assert!(error < STEP, "({column}, {row}): {found:?} for {expected:?}");
    }
    assert!(report.notes[0].contains("its gain map tells of up to"), "{:?}", report.notes);
    let taken = read(ULTRA_HDR).1;
    let expected = "the primaries of the color profile are not those of Rec. 709; the values are taken as they are";
    assert!(taken.notes.iter().any(|note| note == expected), "{:?}", taken.notes);
    let cut = read(&ULTRA_HDR[..ULTRA_HDR.len() - 20]).1;
    let note = cut.notes.iter().find(|note| note.starts_with("its gain map is not used: "));
    assert!(note.is_some_and(|note| note.contains("ends early")), "{:?}", cut.notes);
}

/// A JPEG with another segment behind its start.
fn with_segment(jpeg: &[u8], mark: u8, name: &[u8], contents: &[u8]) -> Vec<u8> {
    let length = (2 + name.len() + contents.len()) as u16;
    [&jpeg[..2], &[0xff, mark], &length.to_be_bytes(), name, contents, &jpeg[2..]].concat()
}

/// A packet of XMP with these attributes and elements of Ultra HDR.
fn xmp(attributes: &str, elements: &str) -> String {
    format!(
        "<x:xmpmeta xmlns:x='adobe:ns:meta/'><rdf:RDF xmlns:rdf='http://www.w3.org/1999/02/22-rdf-syntax-ns#'>\
         <rdf:Description xmlns:hdrgm='http://ns.adobe.com/hdr-gain-map/1.0/' {attributes}>{elements}</rdf:Description>\
         </rdf:RDF></x:xmpmeta>"
    )
}

fn with_xmp(jpeg: &[u8], packet: &str) -> Vec<u8> {
    with_segment(jpeg, 0xe1, b"http://ns.adobe.com/xap/1.0/\0", packet.as_bytes())
}

/// Numbers of ISO 21496-1 with these flags.
fn with_iso(jpeg: &[u8], flags: u8, numbers: &[i32]) -> Vec<u8> {
    let numbers: Vec<u8> = numbers.iter().flat_map(|number| number.to_be_bytes()).collect();
    let block = [&[0, 0, 0, 0, flags], numbers.as_slice()].concat();
    with_segment(jpeg, 0xe2, b"urn:iso:std:iso:ts:21496:-1\0", &block)
}

#[test]
fn gain_maps_brighten_by_their_formula_whatever_form_their_numbers_have() {
    // The gain map is `gray.jpg`, whose stored values a JPEG without a gain map gives back by sRGB's curve.
    let [base, gain] = [read(JPEG).0, read(GRAY).0];
    let stored = |v: f32| {
        let v = f64::from(v);
        if v <= 0.0031308 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
    };
    let list = |numbers: [&str; 3]| {
        let items: String = numbers.iter().map(|number| format!("<rdf:li>{number}</rdf:li>")).collect();
        format!("<hdrgm:GainMapMax><rdf:Seq>{items}</rdf:Seq></hdrgm:GainMapMax>")
    };
    // Of each the least and the greatest stops, gamma, and both offsets.
    let same = |numbers: [f64; 5]| [numbers; 3];
    let by_channels = [2.0, 3.0, 4.0].map(|max| [-1.0, max, 1.0, 1.0 / 64.0, 1.0 / 64.0]);
    let cases = [
        ("defaults", with_xmp(GRAY, &xmp("hdrgm:GainMapMax='4'", "")), same([0.0, 4.0, 1.0, 1.0 / 64.0, 1.0 / 64.0])),
        (
            "attributes",
            with_xmp(
                GRAY,
                &xmp(
                    "hdrgm:GainMapMin='-1' hdrgm:GainMapMax='2.5' hdrgm:Gamma='2' hdrgm:OffsetSDR='0' hdrgm:OffsetHDR='0.5'",
                    "",
                ),
            ),
            same([-1.0, 2.5, 2.0, 0.0, 0.5]),
        ),
        ("elements", with_xmp(GRAY, &xmp("hdrgm:GainMapMin='-1'", &list(["2", "3", "4"]))), by_channels),
        (
            "fractions",
            with_iso(GRAY, 0, &[0, 1, 3, 1, -1, 2, 6, 2, 1, 2, 0, 1, 1, 4]),
            same([-0.5, 3.0, 0.5, 0.0, 0.25]),
        ),
        (
            "three channels over one denominator",
            with_iso(GRAY, 0x88, &[64, 0, 256, -64, 128, 64, 1, 1, -64, 192, 64, 1, 1, -64, 256, 64, 1, 1]),
            by_channels,
        ),
    ];
    // A step of 255 of the gain is 6 % of the least values by these powers of two; steps are the same here, only rounding differs.
    let rounding = 1e-4;
    for (what, second, numbers) in cases {
        let (picture, report) = read(&[JPEG, b"between them".as_slice(), &second].concat());
        assert!(report.notes[0].contains("gain map"), "{what}: {:?}", report.notes);
        for (column, row) in [(0, 0), (15, 0), (0, 7), (9, 4)] {
            for (c, [min, max, gamma, base_offset, other_offset]) in numbers.into_iter().enumerate() {
                let value = stored(gain.pixel(column, row)[c]).powf(1.0 / gamma);
                let expected = ((f64::from(base.pixel(column, row)[c]) + base_offset)
                    * (min + (max - min) * value).exp2()
                    - other_offset)
                    .max(0.0);
                let found = f64::from(picture.pixel(column, row)[c]);
                assert!(
                    (found - expected).abs() < rounding * (1.0 + expected),
                    "{what}: ({column}, {row}), {c}: {found} for {expected}"
                );
            }
        }
    }
}

#[test]
fn gain_maps_that_are_not_used_are_noted_with_the_reason() {
    let plain = read(JPEG).0;
    for (what, bytes, reason) in [
        ("Apple's", [JPEG, &with_xmp(GRAY, "<a HDRGainMap:HDRGainMapVersion='65536'/>")].concat(), "Apple's"),
        ("a broken packet", [JPEG, &with_xmp(GRAY, &xmp("hdrgm:GainMapMax='4", ""))].concat(), "in XMP are damaged"),
        ("a word", [JPEG, &with_xmp(GRAY, &xmp("hdrgm:GainMapMax='much'", ""))].concat(), "in XMP are damaged"),
        ("no denominator", [JPEG, &with_iso(GRAY, 0, &[0; 14])].concat(), "21496-1 are damaged"),
        ("half of its numbers", [JPEG, &with_iso(GRAY, 0, &[1; 7])].concat(), "21496-1 are damaged"),
        ("the bright one first", [JPEG, &with_iso(GRAY, 8, &[1, 3, 0, 0, 1, 1, 0, 0])].concat(), "the bright one"),
        ("none there", with_xmp(JPEG, &xmp("hdrgm:Version='1.0'", "")), "does not have it"),
    ] {
        let (picture, report) = read(&bytes);
        assert_eq!(picture.pixels(), plain.pixels(), "{what}");
        let notes: Vec<_> = report.notes.iter().filter(|note| note.starts_with("its gain map is not used: ")).collect();
        assert!(notes.len() == 1 && notes[0].contains(reason), "{what}: {:?}", report.notes);
        assert!(report.notes[0].contains("cut off"), "{what}: {:?}", report.notes);
    }
}

#[test]
fn pictures_of_films_are_refused_by_name_with_the_command_that_converts_them() {
    for (brand, name) in [(b"avif", "AVIF"), (b"avis", "AVIF"), (b"heic", "HEIF"), (b"mif1", "HEIF")] {
        let bytes = [b"\0\0\0\x1cftyp".as_slice(), brand, b"\0\0\0\0mif1miaf"].concat();
        let found = refusal(&bytes).to_string();
        assert!(found.contains(name) && found.contains("ffmpeg -i IN"), "{found}");
    }
}

const JXL: &[u8] = include_bytes!("../data/float.jxl");

#[cfg(not(feature = "jxl"))]
#[test]
fn jpeg_xl_is_refused_by_name_where_its_decoder_was_left_out() {
    let found = refusal(JXL).to_string();
    assert!(found.contains("feature `jxl`") && found.contains("djxl IN.jxl"), "{found}");
}

#[cfg(feature = "jxl")]
mod jpeg_xl {
    use super::*;

    #[test]
    fn jpeg_xl_of_floating_point_numbers_is_read_with_all_of_its_light() {
        let (picture, report) = read(JXL);
        assert_eq!((report.format, picture.width(), picture.height()), (FileFormat::JpegXl, 32, 16), "head");
        let error = relative_error(&picture, |column, row| light(column, row)[1]);
        assert!(error < 1e-6, "{error}");
        assert!(report.notes.is_empty(), "{:?}", report.notes);
        for length in [3, 50, JXL.len() / 2, JXL.len() - 1] {
            let error = refusal(&JXL[..length]);
            assert!(matches!(error, ImageError::Invalid { .. }), "{length} bytes: {error}");
        }
    }

    /// The luminance of a value of PQ, in cd/m² (SMPTE ST 2084).
    fn luminance(value: f64) -> f64 {
        let root = value.powf(32.0 / 2523.0);
        let [low, high] = [root - 3424.0 / 4096.0, 2413.0 / 128.0 - 2392.0 / 128.0 * root];
        10_000.0 * (low / high).powf(16384.0 / 2610.0)
    }

    #[test]
    fn jpeg_xl_by_pq_has_diffuse_white_at_one_and_nothing_is_tone_mapped() {
        let (picture, report) = read(include_bytes!("../data/pq.jxl"));
        // The file has 16 bits, of which the last is 1.5e-4 of the light at these values.
        let rounding = 1e-3;
        for (column, row) in [(0, 0), (16, 8), (31, 15), (31, 0)] {
            let encoded = [0.2 + column as f64 / 64.0, 0.2 + row as f64 / 32.0, 0.4];
            let expected = encoded.map(|value| luminance(value) / 203.0);
            let found = picture.pixel(column, row).map(f64::from);
            let error = (0..3).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f64::max);
            let largest = expected.into_iter().fold(0.0, f64::max);
            assert!(error < rounding * largest, "({column}, {row}): {found:?} for {expected:?}");
        }
        assert!(report.notes[0].contains("203 cd/m²"), "{:?}", report.notes);
        assert!(report.notes[1].contains("are not those of Rec. 709"), "{:?}", report.notes);
    }

    #[test]
    fn jpeg_xl_of_gray_and_of_another_gamut_keeps_what_is_brighter_than_white() {
        let (picture, _) = read(include_bytes!("../data/gray.jxl"));
        let error = relative_error(&picture, |column, row| [light(column, row)[1][0] + 5.0; 3]);
        assert!(error < 1e-6, "{error}");
        has_the_primaries_of_rec_2020(include_bytes!("../data/wide.jxl"), "JPEG XL");
    }
}
