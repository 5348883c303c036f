//! Round trips of written files.

use std::fs;
use std::path::Path;

use lobe_env::{EnvError, EnvMap, MapReadOptions, MapWriteOptions, MapWriteReport, read_env, write_env};
use lobe_sh::Rgb;
use lobe_testkit::Random;

fn random_map(width: usize, height: usize) -> EnvMap {
    let mut random = Random::new(4);
    let mut channel = || (20.0 * random.signed()).exp2() as f32;
    let texels = (0..width * height).map(|_| Rgb::new(channel(), channel(), channel())).collect();
    EnvMap::new(width, height, texels).unwrap()
}

fn round_trip(name: &str, map: &EnvMap, options: &MapWriteOptions) -> (EnvMap, MapWriteReport) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let report = write_env(&path, map, options).unwrap_or_else(|e| panic!("{e}"));
    let files: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|f| f.unwrap().file_name()).collect();
    assert_eq!(files, [name], "nothing temporary is left");
    (read_env(&path, &MapReadOptions::default()).unwrap_or_else(|e| panic!("{e}")).0, report)
}

/// The largest error of a channel, relative to the largest channel of its texel.
fn error_of(a: &EnvMap, b: &EnvMap) -> f32 {
    assert_eq!((a.width(), a.height()), (b.width(), b.height()), "size");
    let error = |(a, b): (&Rgb<f32>, &Rgb<f32>)| {
        let largest = a.to_array().into_iter().fold(0.0, f32::max);
        (*a - *b).to_array().into_iter().fold(0.0_f32, |e, d| e.max(d.abs())) / largest
    };
    a.texels().iter().zip(b.texels()).map(error).fold(0.0, f32::max)
}

#[test]
fn exr_holds_floats_exactly_and_halves_to_three_digits() {
    let map = random_map(38, 19);
    let (float, report) = round_trip("a.exr", &map, &MapWriteOptions::default());
    assert_eq!((error_of(&map, &float), report.clamped), (0.0, 0), "float");
    let map = EnvMap::from_fn(34, 17, |s| Rgb::new(3.0 + s.x() as f32, 1.5 + s.y() as f32, 9.0));
    let (half, report) = round_trip("a.EXR", &map, &MapWriteOptions::default().half(true));
    assert!(error_of(&map, &half) < 5e-4 && report.clamped == 0, "half: {} {report:?}", error_of(&map, &half));
}

#[test]
fn hdr_holds_two_digits_at_any_width() {
    for (w, h) in [(2, 1), (6, 3), (8, 4), (38, 19), (400, 200)] {
        let map = random_map(w, h);
        let (back, report) = round_trip("a.hdr", &map, &MapWriteOptions::default());
        assert!(error_of(&map, &back) < 0.004 && report.clamped == 0, "{w} x {h}: {}", error_of(&map, &back));
    }
}

#[test]
fn what_a_format_cannot_hold_is_clamped_and_counted() {
    let mut map = EnvMap::from_fn(8, 4, |_| Rgb::new(1.0, 1.0, 1.0));
    map.texels_mut()[3] = Rgb::new(-1.0, 1.0, f32::MAX);
    map.texels_mut()[4] = Rgb::new(1e-40, 1e-39, 0.0);
    map.texels_mut()[5] = Rgb::new(70000.0, 1.0, -70000.0);
    let (hdr, report) = round_trip("a.hdr", &map, &MapWriteOptions::default());
    assert_eq!(report.clamped, 2, "hdr");
    assert!(hdr.texels()[3].r == 0.0 && hdr.texels()[3].b > 1.6e38, "hdr: {:?}", hdr.texels()[3]);
    assert_eq!(hdr.texels()[4], Rgb::new(0.0, 0.0, 0.0), "a tiny number does not become a huge one");
    let (half, report) = round_trip("a.exr", &map, &MapWriteOptions::default().half(true));
    assert_eq!(report.clamped, 2, "half");
    assert_eq!(half.texels()[5], Rgb::new(65504.0, 1.0, -65504.0), "half");
}

#[test]
fn nan_is_black_and_counted_in_hdr_and_kept_in_half() {
    let mut map = EnvMap::from_fn(8, 4, |_| Rgb::new(1.0, 1.0, 1.0));
    map.texels_mut()[9] = Rgb::new(f32::NAN, 1.0, 0.5);
    let (hdr, report) = round_trip("a.hdr", &map, &MapWriteOptions::default());
    assert_eq!((report.clamped, hdr.texels()[9]), (1, Rgb::new(0.0, 1.0, 0.5)), "hdr");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    assert_eq!(write_env(&path, &map, &MapWriteOptions::default().half(true)).unwrap().clamped, 0, "half");
    let error = read_env(&path, &MapReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("column 1, row 1"), "half: {error}");
}

#[test]
fn pfm_has_its_lowest_row_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pfm");
    let map = EnvMap::new(2, 1, vec![Rgb::new(1.0, 2.0, 3.0), Rgb::new(-4.0, 5.5, 6.0)]).unwrap();
    let tall = EnvMap::new(1, 2, map.texels().to_vec()).unwrap();
    write_env(&path, &tall, &MapWriteOptions::default()).unwrap();
    let numbers = [-4.0_f32, 5.5, 6.0, 1.0, 2.0, 3.0].iter().flat_map(|v| v.to_le_bytes());
    let expected: Vec<u8> = b"PF\n1 2\n-1.0\n".iter().copied().chain(numbers).collect();
    assert_eq!(fs::read(path).unwrap(), expected, "bytes of the file");
}

#[test]
fn an_unknown_extension_or_folder_is_an_error_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let map = random_map(4, 2);
    for name in ["a.png", "a", "hdr"] {
        let error = write_env(folder.path().join(name), &map, &MapWriteOptions::default());
        assert!(matches!(error, Err(EnvError::Options(_))), "{name}: {error:?}");
    }
    let error = write_env(Path::new("/no/such/folder/a.exr"), &map, &MapWriteOptions::default());
    assert!(matches!(error, Err(EnvError::Io { .. })), "{error:?}");
    fs::create_dir(folder.path().join("b.exr")).unwrap();
    let error = write_env(folder.path().join("b.exr"), &map, &MapWriteOptions::default());
    assert!(matches!(error, Err(EnvError::Io { .. })), "{error:?}");
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|f| f.unwrap().file_name()).collect();
    assert_eq!(left, ["b.exr"], "nothing but the folder made here");
}

#[test]
fn a_failed_write_keeps_the_old_file_and_a_good_one_replaces_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdr");
    fs::write(&path, "old").unwrap();
    let wide = EnvMap::from_fn(32768, 1, |_| Rgb::new(1.0, 1.0, 1.0));
    let error = write_env(&path, &wide, &MapWriteOptions::default());
    assert!(matches!(&error, Err(EnvError::Options(m)) if m.contains("32767")), "{error:?}");
    assert_eq!(fs::read(&path).unwrap(), b"old", "kept");
    write_env(&path, &random_map(4, 2), &MapWriteOptions::default()).unwrap();
    assert!(fs::read(&path).unwrap().starts_with(b"#?RADIANCE"), "replaced");
}
