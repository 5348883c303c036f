//! `lobe render`: scenes by paths, by irradiance and by transfer.

use lobe::env::{ReadOptions, read_raster};
use lobe::sh::{Quantity, Rgb, ShVec};
use serde_json::Value;

use crate::harness::Dir;

/// A sky of even radiance 1.
fn write_even(dir: &Dir) {
    dir.map("even.exr", 16, 8, |_, _| [1.0; 3]);
}

fn pixels(dir: &Dir, name: &str) -> (usize, usize, Vec<Rgb<f32>>) {
    let (raster, _) = read_raster(dir.path(name), &ReadOptions::default()).unwrap();
    (raster.width, raster.height, raster.texels)
}

fn compared(dir: &Dir, a: &str, b: &str) -> Value {
    serde_json::from_str(&dir.lobe(&format!("compare {a} {b} --json")).arg("--quiet").stdout()).unwrap()
}

#[test]
fn every_mode_makes_a_picture_of_its_size() {
    let dir = Dir::new();
    write_even(&dir);
    for mode in ["truth", "irradiance", "unshadowed", "shadowed", "interreflected", "glossy"] {
        let baked = if ["truth", "irradiance"].contains(&mode) { "" } else { "--bake-samples 16" };
        let args = format!("render built-in:furnace --env even.exr --mode {mode} --size 20x10 --samples 4 {baked}");
        dir.lobe(&format!("{args} -o {mode}.exr")).arg("--quiet").stdout();
        assert_eq!(pixels(&dir, &format!("{mode}.exr")).0, 20, "{mode}");
        let (_, note) = dir.lobe(&format!("{args} -o {mode}.png")).succeeds();
        assert!(note.contains("tone-mapped for looking at, exposure"), "{mode}: {note}");
        assert_eq!(&dir.bytes(&format!("{mode}.png"))[1..4], b"PNG", "{mode}");
    }
}

#[test]
fn in_even_light_irradiance_shows_the_albedo() {
    let dir = Dir::new();
    write_even(&dir);
    dir.lobe(
        "render built-in:ball --env even.exr --mode irradiance --eye 0,0,9 --target 0,0,0 --fov 10 --size 8x8 -o a.exr",
    )
    .arg("--quiet")
    .stdout();
    let (_, _, found) = pixels(&dir, "a.exr");
    let middle = found[4 * 8 + 4].to_array();
    for (found, albedo) in middle.iter().zip([0.7, 0.25, 0.2]) {
        assert!((found - albedo).abs() < 1e-4, "{middle:?}");
    }
}

#[test]
fn transfer_and_truth_look_alike_under_one_expansion() {
    let dir = Dir::new();
    let common = "render built-in:ball --env bundled:sunset --order 4 --size 48x36 --samples 16 --rotate-light 70";
    dir.lobe(&format!("{common} --mode truth --bounces 0 --samples 256 -o truth.exr").replace("--samples 16 ", ""))
        .arg("--quiet")
        .stdout();
    dir.lobe(&format!("{common} --mode shadowed --bake-samples 256 --background light -o shadowed.exr"))
        .arg("--quiet")
        .stdout();
    dir.lobe(&format!("{common} --mode unshadowed --background light -o unshadowed.exr")).arg("--quiet").stdout();
    let (close, far) = (compared(&dir, "shadowed.exr", "truth.exr"), compared(&dir, "unshadowed.exr", "truth.exr"));
    let rmse = |found: &Value| found["rmse"].as_f64().unwrap();
    assert!(rmse(&close) < 0.03 && rmse(&far) > 2.0 * rmse(&close), "{close}, {far}");
}

#[test]
fn a_baked_file_is_rendered_as_it_is() {
    let dir = Dir::new();
    dir.lobe("bake built-in:furnace --mode shadowed --order 3 --samples 64 -o baked.glb --quiet").stdout();
    let common = "--env bundled:studio --mode shadowed --size 16x12";
    dir.lobe(&format!("render baked.glb {common} -o a.exr")).arg("--quiet").stdout();
    dir.lobe(&format!("render built-in:furnace {common} --order 3 --bake-samples 64 -o b.exr")).arg("--quiet").stdout();
    let found = compared(&dir, "a.exr", "b.exr");
    // The file keeps y up and its normals and positions as they are rounded.
    assert!(found["rmse"].as_f64().unwrap() < 1e-4, "{found}");
    for (options, part) in [
        ("--mode interreflected", "--mode interreflected: baked.glb was baked as shadowed"),
        ("--mode shadowed --order 4", "--order 4: baked.glb was baked to order 3"),
        ("--mode shadowed --bake-samples 4", "--bake-samples: baked.glb is baked already"),
    ] {
        let line =
            dir.lobe(&format!("render baked.glb --env bundled:studio {options} -o c.png")).arg("--quiet").error();
        assert!(line.contains(part), "{options}: {line}");
    }
}

#[test]
fn the_truth_has_layers_and_variance() {
    let dir = Dir::new();
    write_even(&dir);
    dir.lobe("render built-in:cornell --env even.exr --mode truth --size 12x9 --samples 16 -o t.exr")
        .arg("--quiet")
        .stdout();
    let bytes = dir.bytes("t.exr");
    for channel in ["variance.R", "albedo.G", "normal.Z", "depth.Z", "coverage.A"] {
        let found = bytes.windows(channel.len()).any(|w| w == channel.as_bytes());
        assert!(found, "channel {channel}");
    }
    dir.lobe("render built-in:cornell --env even.exr --mode truth --size 12x9 --samples 16 --threads 3 -o u.exr")
        .arg("--quiet")
        .stdout();
    assert!(bytes == dir.bytes("u.exr"), "the same bytes for any number of threads");
}

#[test]
fn frames_turn_the_light_and_make_an_animation() {
    let dir = Dir::new();
    dir.lobe(
        "render built-in:furnace --env bundled:studio --mode irradiance --size 8x6 --frames 3 -o turn.png --quiet",
    )
    .stdout();
    assert_eq!(dir.names(), ["turn-000.png", "turn-001.png", "turn-002.png", "turn.png"], "files");
    assert!(dir.bytes("turn.png").windows(4).any(|w| w == b"acTL"), "animated");
    assert!(dir.bytes("turn-000.png") != dir.bytes("turn-001.png"), "the light turns");
    dir.lobe("render built-in:furnace --env bundled:studio --mode irradiance --size 8x6 --frames 2 -o t.exr")
        .arg("--quiet")
        .stdout();
    assert_eq!(dir.names().iter().filter(|n| n.ends_with(".exr")).count(), 2, "frames of values");
}

#[test]
fn expansions_are_lights_if_they_are_radiance() {
    let dir = Dir::new();
    let light = ShVec::constant(2, Rgb::new(1.0, 1.0, 1.0));
    dir.sh("light.sh.json", Quantity::Radiance, light.clone());
    dir.sh("wrong.sh.json", Quantity::Irradiance, light);
    let args = "--mode irradiance --size 4x4 -o a.exr";
    dir.lobe(&format!("render built-in:furnace --env light.sh.json {args}")).arg("--quiet").stdout();
    let line = dir.lobe(&format!("render built-in:furnace --env wrong.sh.json {args}")).arg("--quiet").error();
    assert!(line.starts_with("wrong.sh.json: expected radiance, found irradiance"), "{line}");
}

#[test]
fn what_cannot_be_rendered_is_said_in_one_line() {
    let dir = Dir::new();
    write_even(&dir);
    for (args, part) in [
        ("built-in:teapot --env even.exr --mode truth -o a.png", "there is no such scene in the program"),
        ("missing.glb --env even.exr --mode truth -o a.png", "missing.glb: no such file"),
        ("built-in:ball --env missing.exr --mode truth -o a.png", "missing.exr: no such file"),
        ("built-in:ball --env even.exr --mode truth -o a.jpg", "-o: expected a name that ends in .png or .exr"),
        ("built-in:ball --env even.exr --mode truth -o no/a.png", "no"),
        ("built-in:ball --env even.exr --mode shadowed --bounces 2 -o a.png", "--bounces: only of --mode truth"),
        ("built-in:ball --env even.exr --mode shadowed --surfaces gltf -o a.png", "--surfaces: only of --mode truth"),
        ("built-in:ball --env even.exr --mode truth --lobe ggx:0.1 -o a.png", "--lobe: only of --mode glossy"),
        ("built-in:ball --env even.exr --mode glossy --lobe ggx:3 -o a.png", "expected phong:E with"),
        ("built-in:ball --env even.exr --mode truth --background env -o a.png", "--background: "),
        ("built-in:ball --env even.exr --mode shadowed --order 9 -o a.png", "--order: transfer has an order of 1 to 8"),
        ("built-in:ball --env even.exr --mode truth --eye 1,2,3 -o a.png", "--target"),
        ("built-in:ball --env even.exr --mode truth --eye 1,2,3 --target 1,2,3 -o a.png", "are one point"),
        ("built-in:ball --env even.exr --mode truth --size 0x4 -o a.png", "expected columns x rows"),
        ("built-in:ball --env even.exr --mode truth --fov 180 -o a.png", "below 180 degrees"),
        ("built-in:ball --env even.exr --mode truth --window box -o a.png", "expected hanning"),
        ("built-in:ball --env even.exr --mode magic -o a.png", "possible values: truth"),
    ] {
        let line = dir.lobe(&format!("render {args}")).arg("--quiet").error();
        assert!(line.contains(part), "{args}: {line}");
    }
    assert_eq!(dir.names(), ["even.exr"], "nothing was written");
}
