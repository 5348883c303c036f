//! Backgrounds of `lobe render`: their light, and alpha in files.

use std::fs::File;
use std::io::BufReader;

use lobe::image::{ExrLayers, PictureReadOptions, read_picture};

use crate::harness::Dir;

/// A ball that takes a part of the picture, with little to compute.
const VIEW: &str = "built-in:ball --env bundled:sunset --size 24x18 --eye 5,-7,1.6 --target 0,0,1.2 --fov 30";

/// The methods, each with what makes it quick.
const MODES: [&str; 5] = [
    "trace --samples 16 --bounces 0",
    "irradiance",
    "maps",
    "baked --mode shadowed --no-split --bake-samples 4",
    "baked --mode glossy --bake-samples 4 --order 2",
];

/// A corner of the picture, where the sky is.
fn corner(dir: &Dir, name: &str) -> [f32; 3] {
    read_picture(dir.path(name), &PictureReadOptions::default()).unwrap().0.pixel(0, 0)
}

fn render(dir: &Dir, args: &str) {
    dir.lobe(&format!("render {args} {VIEW}")).arg("--quiet").stdout();
}

#[test]
fn a_color_is_behind_the_scene_by_every_method() {
    let dir = Dir::new();
    for mode in MODES {
        render(&dir, &format!("{mode} --background 0.25,0,3 -o a.exr"));
        let found = corner(&dir, "a.exr");
        assert!((found[0] - 0.25).abs() + found[1] + (found[2] - 3.0).abs() < 1e-5, "{mode}: {found:?}");
    }
}

#[test]
fn the_map_is_behind_the_scene_and_its_expansion_only_when_asked_for() {
    let dir = Dir::new();
    let of = |args: &str| {
        render(&dir, &format!("{args} -o a.exr"));
        corner(&dir, "a.exr")
    };
    let map = of("irradiance");
    let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|c| (a[c] - b[c]).abs() < 0.05 * b[c].abs());
    // Paths are spread over the pixel.
    for mode in ["trace --samples 256 --bounces 0", "trace --samples 256 --bounces 0 --order 3", "maps"] {
        assert!(near(of(mode), map), "{mode}: the map");
    }
    let light = of("irradiance --suns none --background light");
    assert!(!near(light, map), "the expansion differs from the map: {light:?}, {map:?}");
    let traced = of("trace --samples 256 --bounces 0 --order 3 --suns none --background light");
    assert!(near(traced, light), "the light of the truth: {traced:?}, {light:?}");
}

#[test]
fn before_nothing_exr_is_premultiplied_and_png_is_straight() {
    let dir = Dir::new();
    for mode in MODES {
        render(&dir, &format!("{mode} --background none -o a.exr"));
        let bytes = dir.bytes("a.exr");
        let layers = ExrLayers::from_bytes(&bytes, "a.exr").unwrap();
        let alpha = layers.get("A").expect("an alpha");
        assert_eq!(alpha[0], 0.0, "{mode}: the corner");
        assert!(alpha.contains(&1.0) && alpha.iter().any(|a| *a > 0.0 && *a < 1.0), "{mode}: the ball and its edge");
        let nothing = (0..alpha.len()).filter(|&i| alpha[i] == 0.0);
        let colors = ["R", "G", "B"].map(|name| layers.get(name).unwrap());
        assert!(nothing.into_iter().all(|i| colors.iter().all(|c| c[i] == 0.0)), "{mode}: nothing sends light");

        // A pixel of the edge has the color of its neighbor on the ball, or one like it, not that of black.
        render(&dir, &format!("{mode} --background none -o a.png --exposure 0"));
        let decoder = png::Decoder::new(BufReader::new(File::open(dir.path("a.png")).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        assert_eq!(reader.info().color_type, png::ColorType::Rgba, "{mode}");
        let mut shown = vec![0; 4 * alpha.len()];
        reader.next_frame(&mut shown).unwrap();
        for (i, pixel) in shown.as_chunks::<4>().0.iter().enumerate() {
            let expected = (255.0 * alpha[i]).round();
            assert!((f32::from(pixel[3]) - expected).abs() < 1.0, "{mode}, pixel {i}: alpha {} {expected}", pixel[3]);
            assert!(pixel[3] > 0 || pixel[..3] == [0; 3], "{mode}, pixel {i}: {pixel:?}");
        }
    }
}

#[test]
fn an_animation_before_nothing_has_an_alpha() {
    let dir = Dir::new();
    render(&dir, "irradiance --background none --frames 2 -o turn.png");
    for name in ["turn.png", "turn-000.png", "turn-001.png"] {
        let decoder = png::Decoder::new(BufReader::new(File::open(dir.path(name)).unwrap()));
        assert_eq!(decoder.read_info().unwrap().info().color_type, png::ColorType::Rgba, "{name}");
    }
}
