//! Round trips of written files.

use std::fs;
use std::path::Path;

use lobe_image::{
    ImageError, Picture, PictureReadOptions, PictureWriteOptions, PictureWriteReport, Tone, encode_picture,
    read_picture, read_picture_bytes, write_picture,
};
use lobe_testkit::Random;

fn random_map(width: usize, height: usize) -> Picture {
    let mut random = Random::new(4);
    let mut channel = || (20.0 * random.signed()).exp2() as f32;
    let texels = (0..width * height).map(|_| [channel(), channel(), channel()]).collect();
    Picture::new(width, height, texels).unwrap()
}

fn round_trip(name: &str, map: &Picture, options: &PictureWriteOptions) -> (Picture, PictureWriteReport) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let report = write_picture(&path, map, options).unwrap_or_else(|e| panic!("{e}"));
    let files: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|f| f.unwrap().file_name()).collect();
    assert_eq!(files, [name], "nothing temporary is left");
    (read_picture(&path, &PictureReadOptions::default()).unwrap_or_else(|e| panic!("{e}")).0, report)
}

/// The largest error of a channel, relative to the largest channel of its texel.
fn error_of(a: &Picture, b: &Picture) -> f32 {
    assert_eq!((a.width(), a.height()), (b.width(), b.height()), "size");
    let error = |(a, b): (&[f32; 3], &[f32; 3])| {
        let largest = a.iter().copied().fold(0.0, f32::max);
        a.iter().zip(b).fold(0.0_f32, |e, (a, b)| e.max((a - b).abs())) / largest
    };
    a.pixels().iter().zip(b.pixels()).map(error).fold(0.0, f32::max)
}

#[test]
fn exr_holds_floats_exactly_and_halves_to_three_digits() {
    let map = random_map(38, 19);
    let (float, report) = round_trip("a.exr", &map, &PictureWriteOptions::default());
    assert_eq!((error_of(&map, &float), report.clamped), (0.0, 0), "float");
    let map = Picture::from_fn(34, 17, |x, y| [3.0 + 0.03 * x as f32, 1.5 + 0.1 * y as f32, 9.0]);
    let (half, report) = round_trip("a.EXR", &map, &PictureWriteOptions::default().half(true));
    assert!(error_of(&map, &half) < 5e-4 && report.clamped == 0, "half: {} {report:?}", error_of(&map, &half));
}

#[test]
fn hdr_holds_two_digits_at_any_width() {
    for (w, h) in [(2, 1), (6, 3), (8, 4), (38, 19), (400, 200)] {
        let map = random_map(w, h);
        let (back, report) = round_trip("a.hdr", &map, &PictureWriteOptions::default());
        assert!(error_of(&map, &back) < 0.004 && report.clamped == 0, "{w} x {h}: {}", error_of(&map, &back));
    }
}

#[test]
fn what_a_format_cannot_hold_is_clamped_and_counted() {
    let mut map = Picture::filled(8, 4, [1.0, 1.0, 1.0]);
    map.pixels_mut()[3] = [-1.0, 1.0, f32::MAX];
    map.pixels_mut()[4] = [1e-40, 1e-39, 0.0];
    map.pixels_mut()[5] = [70000.0, 1.0, -70000.0];
    let (hdr, report) = round_trip("a.hdr", &map, &PictureWriteOptions::default());
    assert_eq!(report.clamped, 2, "hdr");
    assert!(hdr.pixels()[3][0] == 0.0 && hdr.pixels()[3][2] > 1.6e38, "hdr: {:?}", hdr.pixels()[3]);
    assert_eq!(hdr.pixels()[4], [0.0, 0.0, 0.0], "a tiny number does not become a huge one");
    let (half, report) = round_trip("a.exr", &map, &PictureWriteOptions::default().half(true));
    assert_eq!(report.clamped, 2, "half");
    assert_eq!(half.pixels()[5], [65504.0, 1.0, -65504.0], "half");
}

#[test]
fn nan_is_black_and_counted_in_hdr_and_kept_in_half() {
    let mut map = Picture::filled(8, 4, [1.0, 1.0, 1.0]);
    map.pixels_mut()[9] = [f32::NAN, 1.0, 0.5];
    let (hdr, report) = round_trip("a.hdr", &map, &PictureWriteOptions::default());
    assert_eq!((report.clamped, hdr.pixels()[9]), (1, [0.0, 1.0, 0.5]), "hdr");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    assert_eq!(write_picture(&path, &map, &PictureWriteOptions::default().half(true)).unwrap().clamped, 0, "half");
    let error = read_picture(&path, &PictureReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("column 1, row 1"), "half: {error}");
}

#[test]
fn pfm_has_its_lowest_row_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pfm");
    let map = Picture::new(2, 1, vec![[1.0, 2.0, 3.0], [-4.0, 5.5, 6.0]]).unwrap();
    let tall = Picture::new(1, 2, map.pixels().to_vec()).unwrap();
    write_picture(&path, &tall, &PictureWriteOptions::default()).unwrap();
    let numbers = [-4.0_f32, 5.5, 6.0, 1.0, 2.0, 3.0].iter().flat_map(|v| v.to_le_bytes());
    let expected: Vec<u8> = b"PF\n1 2\n-1.0\n".iter().copied().chain(numbers).collect();
    assert_eq!(fs::read(path).unwrap(), expected, "bytes of the file");
}

#[test]
fn what_cannot_be_encoded_is_refused() {
    let picture = random_map(4, 2);
    for name in ["a.png", "a", "hdr"] {
        let error = encode_picture(Path::new(name), 4, picture.pixels(), &PictureWriteOptions::default());
        assert!(matches!(error, Err(ImageError::Options(_))), "{name}: {error:?}");
    }
    let error = encode_picture(Path::new("a.hdr"), 32768, &[[1.0; 3]; 32768], &PictureWriteOptions::default());
    assert!(matches!(&error, Err(ImageError::Options(m)) if m.contains("32767")), "{error:?}");
}

#[test]
fn the_name_of_a_mapping_comes_back_from_every_format_with_room_for_it() {
    let options = PictureWriteOptions::default().mapping("octahedral".to_owned());
    let picture = random_map(8, 8);
    let mapping = |bytes: &[u8]| read_picture_bytes(bytes, "test", &PictureReadOptions::default()).unwrap().1.mapping;
    for (name, expected) in [("a.exr", Some("octahedral")), ("a.hdr", Some("octahedral")), ("a.pfm", None)] {
        let bytes = encode_picture(Path::new(name), 8, picture.pixels(), &options).unwrap().0;
        assert_eq!(mapping(&bytes).as_deref(), expected, "{name}");
        let without = encode_picture(Path::new(name), 8, picture.pixels(), &PictureWriteOptions::default()).unwrap().0;
        assert_eq!(mapping(&without), None, "{name} without a mapping");
    }
    let png = picture.to_png_with(&Tone::PLAIN, Some("octahedral")).unwrap();
    assert_eq!(mapping(&png).as_deref(), Some("octahedral"), "PNG");
    let lines = PictureWriteOptions::default().mapping("two\nlines".to_owned());
    let error = encode_picture(Path::new("a.hdr"), 8, picture.pixels(), &lines).unwrap_err().to_string();
    assert!(error.contains("one line"), "{error}");
}
