//! `lobe render maps`: scenes by environment mapping.

use serde_json::Value;

use crate::harness::{Dir, mean};

/// A sky of even radiance 1, and one of three colors, brighter above.
fn write_skies(dir: &Dir) {
    dir.map("even.exr", 16, 8, |_, _| [1.0; 3]);
    dir.map("sky.exr", 32, 16, |x, y| [1.0 + 0.05 * x as f32, 2.0 - 0.1 * y as f32, 0.5]);
    dir.file("s.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
}

/// A white square that fills the picture.
const SQUARE: &str = "s.obj --up z --eye 0,-2,3 --target 0,0,0 --fov 8 --size 8x6 --quiet";

fn rmse(dir: &Dir, a: &str, b: &str) -> f64 {
    let found: Value = serde_json::from_str(&dir.lobe(&format!("compare {a} {b} --json --quiet")).stdout()).unwrap();
    found["rmse"].as_f64().unwrap()
}

#[test]
fn in_even_light_white_surfaces_vanish_if_they_are_matte_or_smooth_metals() {
    let dir = Dir::new();
    write_skies(&dir);
    for finish in
        ["--surfaces matte", "--metallic 1 --roughness 0", "--surfaces gltf-separable --metallic 1 --roughness 0"]
    {
        dir.lobe(&format!("render maps {SQUARE} --env even.exr {finish} -o a.exr")).stdout();
        for number in dir.numbers("a.exr") {
            assert!((number - 1.0).abs() < 1e-3, "{finish}: {number}");
        }
    }
    dir.lobe(&format!("render maps {SQUARE} --env even.exr --metallic 1 --roughness 1 -o a.png --exposure 0")).stdout();
    assert_eq!(&dir.bytes("a.png")[1..4], b"PNG", "a picture for looking at");
}

#[test]
fn a_finish_means_the_same_in_the_truth() {
    let dir = Dir::new();
    write_skies(&dir);
    for (finish, allowed) in [("--surfaces matte", 0.05), ("--surfaces gltf --roughness 0 --metallic 1", 0.1)] {
        let common = format!("--env sky.exr --rotate-light 50 {finish}");
        dir.lobe(&format!("render maps {SQUARE} {common} -o maps.exr")).stdout();
        dir.lobe(&format!("render trace {SQUARE} --bounces 0 --samples 256 {common} -o truth.exr")).stdout();
        let (found, whole) = (rmse(&dir, "maps.exr", "truth.exr"), mean(&dir.numbers("maps.exr")));
        assert!(found < allowed * whole, "{finish}: {found} of {whole}");
    }
}

#[test]
fn frames_turn_the_light_and_stored_pictures_blur_what_mirrors_show() {
    let dir = Dir::new();
    write_skies(&dir);
    let mirror = format!("render maps {SQUARE} --env sky.exr --metallic 1 --roughness 0");
    dir.lobe(&format!("{mirror} --frames 2 -o turn.png")).stdout();
    assert!(dir.bytes("turn-000.png") != dir.bytes("turn-001.png"), "the light turns");
    assert!(dir.bytes("turn.png").windows(4).any(|w| w == b"acTL"), "animated");
    dir.lobe(&format!("{mirror} -o map.exr")).stdout();
    let error = |through: &str| {
        dir.lobe(&format!("{mirror} --reflect-through {through} -o through.exr")).stdout();
        rmse(&dir, "through.exr", "map.exr")
    };
    let (coarse, fine) = (error("sphere:2"), error("lat-long"));
    assert!(fine < coarse, "sphere map of 2 rows {coarse}, as many texels as the map {fine}");
}

#[test]
fn what_environment_mapping_cannot_do_is_said_in_one_line() {
    let dir = Dir::new();
    write_skies(&dir);
    dir.file("light.sh.json", "{}");
    for (args, part) in [
        ("maps --env light.sh.json", "lobe env reconstruct makes one of an expansion"),
        ("maps --env sky.exr --order 3", "unexpected argument '--order'"),
        ("maps --env sky.exr --time 1", "--time: only what a glTF file moves"),
        ("maps --env sky.exr --surfaces matte --roughness 0", "--roughness: matte surfaces have none"),
        ("maps --env sky.exr --surfaces matte --reflect-through cube", "--reflect-through: matte surfaces"),
        ("maps --env sky.exr --roughness 2", "expected a number from 0 to 1, found 2"),
        ("maps --env sky.exr --reflect-through ball", "expected lat-long, sphere, "),
        ("maps --env sky.exr --reflect-through cube:0", "a number of rows from 1 to"),
        ("maps --env sky.exr --max-memory 0.001", "filtering sky.exr takes up to "),
        ("trace --env sky.exr --metallic 1", "--metallic: matte surfaces have none; ask for --surfaces gltf"),
    ] {
        let line = dir.lobe(&format!("render {args} {SQUARE} -o a.png")).error();
        assert!(line.contains(part), "{args}: {line}");
    }
    let line =
        dir.lobe("render trace built-in:walking-figure --surfaces gltf --roughness 0.5 --env sky.exr -o a.png --quiet");
    let line = line.error();
    assert!(line.contains("--roughness: only of a scene that stands still"), "{line}");
    assert!(!dir.names().contains(&"a.png".to_owned()), "nothing was written: {:?}", dir.names());
}
