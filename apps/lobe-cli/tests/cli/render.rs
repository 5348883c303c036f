//! `lobe render`: scenes by paths, by irradiance and by transfer.

use std::f64::consts::PI;

use lobe::image::{Curve, Exposure, Picture, PictureReadOptions, Tone, read_picture};
use lobe::io::Job;
use lobe::prt::{Channels, Recipe, Transfer, read_transfer, write_lightmap};
use lobe::sh::expansion::Quantity;
use lobe::sh::{Rgb, ShVec};
use serde_json::Value;

use crate::harness::Dir;

/// A sky of even radiance 1.
fn write_even(dir: &Dir) {
    dir.map("even.exr", 16, 8, |_, _| [1.0; 3]);
}

fn pixels(dir: &Dir, name: &str) -> (usize, usize, Vec<Rgb<f32>>) {
    let (picture, _) = read_picture(dir.path(name), &PictureReadOptions::default()).unwrap();
    (picture.width(), picture.height(), picture.into_pixels())
}

fn compared(dir: &Dir, a: &str, b: &str) -> Value {
    serde_json::from_str(&dir.lobe(&format!("compare {a} {b} --json")).arg("--quiet").stdout()).unwrap()
}

/// A view of three walls of the built-in furnace.
const INSIDE: &str = "--eye 0.9,0.8,0.7 --target -1,-0.9,-0.8";

#[test]
fn every_mode_makes_a_picture_of_its_size_with_what_gets_into_a_closed_box() {
    let dir = Dir::new();
    write_even(&dir);
    for (mode, method, expected) in [
        ("trace", "trace", 0.0),
        ("irradiance", "irradiance", 1.0),
        ("unshadowed", "baked --bake-samples 16 --mode unshadowed", 1.0),
        ("shadowed", "baked --no-split --bake-samples 16 --mode shadowed", 0.0),
        ("interreflected", "--no-split --bake-samples 16", 0.0),
        ("glossy", "baked --bake-samples 16 --mode glossy", 0.0),
    ] {
        let args = format!("render {method} built-in:furnace --env even.exr {INSIDE} --size 20x10 --samples 4");
        dir.lobe(&format!("{args} -o {mode}.exr")).arg("--quiet").stdout();
        let (width, height, found) = pixels(&dir, &format!("{mode}.exr"));
        assert_eq!((width, height), (20, 10), "{mode}");
        for pixel in found {
            // Light has been rounded to f32 and projected from a picture.
            let error = pixel.to_array().map(|c| (c - expected).abs()).into_iter().fold(0.0, f32::max);
            assert!(error <= 1e-5 * expected, "{mode}: {pixel:?} instead of {expected}");
        }
        let (_, note) = dir.lobe(&format!("{args} -o {mode}.png")).succeeds();
        assert!(note.contains("tone-mapped by reinhard, exposure "), "{mode}: {note}");
        assert_eq!(&dir.bytes(&format!("{mode}.png"))[1..4], b"PNG", "{mode}");
    }
}

#[test]
fn a_white_square_vanishes_in_even_light() {
    let dir = Dir::new();
    write_even(&dir);
    dir.file("s.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
    let args = "s.obj --up z --env even.exr --eye 0,-3,3 --target 0,0,0 --fov 50 --size 16x12";
    dir.lobe(&format!("render irradiance {args} -o irradiance.exr")).arg("--quiet").stdout();
    for mode in ["unshadowed", "shadowed", "interreflected"] {
        dir.lobe(&format!("render {args} --mode {mode} -o {mode}.exr")).arg("--quiet").stdout();
    }
    for mode in ["irradiance", "unshadowed", "shadowed", "interreflected"] {
        for pixel in pixels(&dir, &format!("{mode}.exr")).2 {
            assert!((pixel.g - 1.0).abs() < 1e-5, "{mode}: {pixel:?}");
        }
    }
    dir.lobe(&format!("render trace {args} --samples 256 -o truth.exr")).arg("--quiet").stdout();
    let found = pixels(&dir, "truth.exr").2;
    let mean = found.iter().map(|p| f64::from(p.g)).sum::<f64>() / found.len() as f64;
    // A path brings 0 to 1.5, so that it deviates by 0.75 at most; five deviations of the mean of all.
    let allowed = 5.0 * 0.75 / (256.0 * found.len() as f64).sqrt();
    assert!((mean - 1.0).abs() < allowed, "truth: {mean}, allowed {allowed}");
}

#[test]
fn in_even_light_irradiance_shows_the_albedo() {
    let dir = Dir::new();
    write_even(&dir);
    dir.lobe("render irradiance built-in:ball --env even.exr --eye 0,0,9 --target 0,0,0 --fov 10 --size 8x8 -o a.exr")
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
    let common = "built-in:ball --env bundled:sunset --order 4 --size 48x36 --rotate-light 70 --quiet";
    dir.lobe(&format!("render trace {common} --bounces 0 --samples 256 -o truth.exr")).stdout();
    let baked = format!("render {common} --samples 16");
    dir.lobe(&format!("{baked} --mode shadowed --no-split --bake-samples 256 -o shadowed.exr")).stdout();
    dir.lobe(&format!("{baked} --mode unshadowed -o unshadowed.exr")).stdout();
    let (close, far) = (compared(&dir, "shadowed.exr", "truth.exr"), compared(&dir, "unshadowed.exr", "truth.exr"));
    let rmse = |found: &Value| found["rmse"].as_f64().unwrap();
    assert!(rmse(&close) < 0.03 && rmse(&far) > 2.0 * rmse(&close), "{close}, {far}");
}

#[test]
fn a_baked_file_is_rendered_as_it_is() {
    let dir = Dir::new();
    // The file keeps y up and its normals and positions as they are rounded.
    let alike = |a: &str, b: &str| {
        let found = compared(&dir, a, b);
        assert!(found["rmse"].as_f64().unwrap() < 1e-4, "{a}, {b}: {found}");
        let mean = pixels(&dir, a).2.iter().map(|p| f64::from(p.g)).sum::<f64>();
        assert!(mean > 1.0, "{a} is not black: {mean}");
    };
    // Unshadowed transfer of order 3 is the irradiance, albedo 1.
    dir.lobe("bake built-in:furnace --mode unshadowed --order 3 -o white.glb --quiet").stdout();
    let common = format!("--env bundled:studio --size 16x12 {INSIDE}");
    for (scene, mode, to) in [
        ("white.glb", "baked", "a"),
        ("built-in:furnace", "baked --mode unshadowed --order 3", "b"),
        ("built-in:furnace", "irradiance", "c"),
    ] {
        dir.lobe(&format!("render {mode} {scene} {common} -o {to}.exr")).arg("--quiet").stdout();
    }
    alike("a.exr", "b.exr");
    alike("a.exr", "c.exr");
    dir.lobe("bake built-in:cornell --no-split --mode shadowed --order 3 --samples 64 -o baked.glb --quiet").stdout();
    let common = "--env bundled:studio --mode shadowed --size 16x12";
    dir.lobe(&format!("render baked.glb {common} -o d.exr")).arg("--quiet").stdout();
    dir.lobe(&format!("render built-in:cornell {common} --no-split --order 3 --bake-samples 64 -o e.exr"))
        .arg("--quiet")
        .stdout();
    alike("d.exr", "e.exr");
    dir.lobe(&format!("render baked.glb {common} --bake-samples 64 -o f.exr")).arg("--quiet").stdout();
    assert!(dir.bytes("f.exr") == dir.bytes("d.exr"), "an option that is as in the bake changes nothing");
    dir.lobe("bake built-in:cornell --no-split --order 2 --samples 4 --bounces 2 -o light.glb --quiet").stdout();
    let common = "render light.glb --env bundled:studio --mode interreflected --size 16x12 --quiet -o g.exr --bounces";
    dir.lobe(&format!("{common} 2")).stdout();
    let line = dir.lobe(&format!("{common} 3")).error();
    assert!(line.starts_with("--bounces: light.glb is baked with 2, not with 3; leave the option out"), "{line}");
    for (options, part) in [
        ("--mode interreflected", "--mode: baked.glb was baked as shadowed, not as interreflected"),
        ("--mode shadowed --order 4", "--order: baked.glb was baked to order 3, not 4"),
        (
            "--mode shadowed --bake-samples 4",
            "--bake-samples: baked.glb is baked with 64, not with 4; leave the option out",
        ),
    ] {
        let line =
            dir.lobe(&format!("render baked.glb --env bundled:studio {options} -o c.png")).arg("--quiet").error();
        assert!(line.contains(part), "{options}: {line}");
    }
}

/// A square of side 4 in 16 x 16 cells under a square of side 1, unfolded side by side.
fn write_shaded_square(dir: &Dir) {
    let (mut vertices, mut faces) = (String::new(), String::new());
    for k in 0..17 * 17 {
        let (x, y) = (k % 17, k / 17);
        vertices += &format!(
            "v {} {} 0\nvt {} {}\n",
            f64::from(x) / 4.0 - 2.0,
            f64::from(y) / 4.0 - 2.0,
            f64::from(x) / 24.0,
            f64::from(y) / 24.0
        );
        if x < 16 && y < 16 {
            let [a, b, c, d] = [k + 1, k + 2, k + 19, k + 18];
            faces += &format!("f {a}/{a} {b}/{b} {c}/{c} {d}/{d}\n");
        }
    }
    for (x, y) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
        vertices += &format!(
            "v {} {} 0.8\nvt {} {}\n",
            f64::from(x) - 0.5,
            f64::from(y) - 0.5,
            0.75 + f64::from(x) / 5.0,
            0.75 + f64::from(y) / 5.0
        );
    }
    dir.file("square.obj", format!("{vertices}{faces}f 290/290 291/291 292/292 293/293\n"));
}

#[test]
fn demodulated_transfer_shows_the_texture_that_vertices_lose_and_says_so_in_its_recipe() {
    let dir = Dir::new();
    // One square with a texture of 4 x 4 cells.
    let cell = |x: usize, y: usize| if (x / 4 + y / 4).is_multiple_of(2) { [1.0, 0.5, 0.0] } else { [0.0, 0.5, 1.0] };
    Picture::from_fn(16, 16, cell).write_png(dir.path("cells.png"), &Tone::PLAIN).unwrap();
    dir.file("square.mtl", "newmtl cells\nKd 1 1 1\nmap_Kd cells.png\n");
    let corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    dir.file("square.obj", format!("mtllib square.mtl\n{corners}usemtl cells\nf 1/1 2/2 3/3 4/4\n"));
    let common = "--env bundled:studio --size 32x24 --eye 0,-0.1,4 --target 0,0,0 --quiet";
    for albedo in ["vertex", "none"] {
        let bake =
            format!("bake square.obj --up z --mode unshadowed --order 3 --albedo {albedo} -o {albedo}.safetensors");
        dir.lobe(&bake).arg("--quiet").stdout();
        let transfer = format!("--transfer {albedo}.safetensors -o {albedo}.exr");
        dir.lobe(&format!("render square.obj --up z --mode unshadowed {common} {transfer}")).stdout();
    }
    dir.lobe(&format!("render irradiance square.obj --up z {common} -o open.exr")).stdout();
    let recipe = |name: &str| read_transfer(dir.path(name)).unwrap().1.albedo;
    let recipes = [recipe("vertex.safetensors"), recipe("none.safetensors")];
    assert_eq!(recipes, [None, Some("none".to_owned())], "recipes");
    // Unshadowed transfer of order 3 is irradiance, by its formula.
    let rmse = |name: &str| compared(&dir, name, "open.exr")["rmse"].as_f64().unwrap();
    let (vertex, none) = (rmse("vertex.exr"), rmse("none.exr"));
    assert!(none < 1e-5 && vertex > 0.02, "the root mean square error is {none}, with the albedo of vertices {vertex}");
    let line = dir.lobe("bake square.obj --mode glossy --albedo none -o m.safetensors").error();
    assert!(line.contains("matrices never have the albedo"), "{line}");
    for command in ["bake square.obj -o b.glb --quiet", &format!("render irradiance square.obj {common} -o b.png")] {
        let line = dir.lobe(&format!("{command} --max-texels 255")).error();
        assert!(line.contains("square.obj: expected textures of at most 255 texels"), "{command}: {line}");
    }
}

#[test]
fn texels_and_vertices_show_the_same_light() {
    let dir = Dir::new();
    write_shaded_square(&dir);
    let bake =
        |args: &str| dir.lobe(&format!("bake square.obj --up z --samples 256 --order 3 --quiet {args}")).stdout();
    bake("-o vertices.safetensors");
    bake("-o texels.safetensors --texels 48");
    bake("-o texels.exr --texels 48");
    let view = "--eye 0.1,-0.2,9 --target 0,0,0 --fov 22 --size 32x32 --samples 16 --background light";
    for (from, to) in [("vertices.safetensors", "a"), ("texels.safetensors", "b"), ("texels.exr", "c")] {
        let args = format!(
            "render square.obj --up z --env bundled:studio --mode interreflected {view} --transfer {from} -o {to}.exr"
        );
        dir.lobe(&args).arg("--quiet").stdout();
    }
    assert!(dir.bytes("b.exr") == dir.bytes("c.exr"), "one lightmap in two files");
    let found = compared(&dir, "a.exr", "b.exr");
    let rmse = found["rmse"].as_f64().unwrap();
    let shown = pixels(&dir, "a.exr").2;
    let mean = shown.iter().map(|pixel| f64::from(pixel.g)).sum::<f64>() / shown.len() as f64;
    assert!(rmse < 0.02 * mean, "{found}, mean {mean}");
    for (args, part) in [
        ("--transfer texels.exr --mode shadowed", "--mode: texels.exr was baked as interreflected"),
        ("--transfer texels.exr --mode interreflected --order 4", "--order: texels.exr was baked to order 3"),
        ("--transfer square.obj --mode interreflected", "square.obj: expected safetensors"),
    ] {
        let line = dir.lobe(&format!("render square.obj --env bundled:studio -o d.exr {args}")).arg("--quiet").error();
        assert!(line.contains(part), "{args}: {line}");
    }
    let line = dir.lobe(
        "render built-in:ball --env bundled:studio --mode interreflected -o d.exr --transfer vertices.safetensors",
    );
    let line = line.arg("--quiet").error();
    assert!(line.contains("vertices as the scene has, found 293"), "{line}");
}

#[test]
fn a_pattern_planted_in_a_lightmap_is_seen_where_its_texels_are() {
    let dir = Dir::new();
    write_even(&dir);
    dir.file("s.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
    let planted = |x: usize, y: usize| f64::from(u8::from((5 * x + 3 * y) % 7 < 3)) + 0.1 * x as f64;
    // Even light of radiance 1 is √(4π) y_0.
    let values = (0..64).map(|texel| (planted(texel % 8, texel / 8) / (4.0 * PI).sqrt()) as f32).collect();
    let transfer = Transfer::new(1, Channels::Gray, values).unwrap();
    write_lightmap(dir.path("p.exr"), &transfer, &Recipe::default(), Job::default()).unwrap();
    // Seen from above +x is up and +y to the left: 8 x 8 pixels of two by two rays, each over a texel.
    let fov = 2.0 * f64::atan(0.1).to_degrees();
    let args =
        format!("render s.obj --up z --env even.exr --mode shadowed --transfer p.exr -o a.exr --fov {fov} --size 8x8");
    dir.lobe(&format!("{args} --eye 0,0,10 --target 0,0,0")).arg("--quiet").stdout();
    // Rays a quarter of a texel from its center, linear between centers: 3/4 of the texel and 1/8 of each neighbor.
    let clamped = |i: usize, by: isize| (i as isize + by).clamp(0, 7) as usize;
    let filtered = |f: &dyn Fn(isize) -> f64| 0.125 * f(-1) + 0.75 * f(0) + 0.125 * f(1);
    for (k, pixel) in pixels(&dir, "a.exr").2.iter().enumerate() {
        // The file's v points up: row 0 of the picture is y = 1.
        let (x, y) = (7 - k / 8, k % 8);
        let expected = filtered(&|i| filtered(&|j| planted(clamped(x, i), clamped(y, j))));
        assert!((f64::from(pixel.g) - expected).abs() < 1e-3, "texel {x}, {y}: {pixel:?}, not {expected}");
    }
}

#[test]
fn the_truth_has_layers_and_variance() {
    let dir = Dir::new();
    write_even(&dir);
    dir.lobe("render trace built-in:cornell --env even.exr --size 12x9 --samples 16 -o t.exr").arg("--quiet").stdout();
    let bytes = dir.bytes("t.exr");
    for channel in ["variance.R", "albedo.G", "normal.Z", "depth.Z", "coverage.A"] {
        let found = bytes.windows(channel.len()).any(|w| w == channel.as_bytes());
        assert!(found, "channel {channel}");
    }
    dir.lobe("render trace built-in:cornell --env even.exr --size 12x9 --samples 16 --threads 3 -o u.exr")
        .arg("--quiet")
        .stdout();
    assert!(bytes == dir.bytes("u.exr"), "the same bytes for any number of threads");
}

#[test]
fn frames_turn_the_light_and_make_an_animation() {
    let dir = Dir::new();
    dir.lobe(&format!(
        "render irradiance built-in:furnace {INSIDE} --env bundled:studio --size 8x6 --frames 3 -o turn.png --quiet"
    ))
    .stdout();
    assert_eq!(dir.names(), ["turn-000.png", "turn-001.png", "turn-002.png", "turn.png"], "files");
    assert!(dir.bytes("turn.png").windows(4).any(|w| w == b"acTL"), "animated");
    assert!(dir.bytes("turn-000.png") != dir.bytes("turn-001.png"), "the light turns");
    dir.lobe("render irradiance built-in:furnace --env bundled:studio --size 8x6 --frames 2 -o t.exr")
        .arg("--quiet")
        .stdout();
    assert_eq!(dir.names().iter().filter(|n| n.ends_with(".exr")).count(), 2, "frames of values");
}

#[test]
fn light_that_rings_below_zero_is_said_to_and_a_window_stops_it() {
    let dir = Dir::new();
    // A sun below the horizon: what the ground gets of it is the ringing of the other side.
    dir.lobe("light directional --dir 0,1,-1 --order 3 --normalize none -o sun.sh.json").stdout();
    let render = "render built-in:terrain --env sun.sh.json --mode unshadowed --size 32x24 -o r.exr --bake-samples 4";
    let (_, stderr) = dir.lobe(render).succeeds();
    assert!(
        stderr.contains("% of what is seen of the scene is below zero, because the light rings; --window"),
        "{stderr}"
    );
    let (_, stderr) = dir.lobe(&format!("{render} --window gauss:90")).succeeds();
    assert!(!stderr.contains("below zero"), "{stderr}");
}

#[test]
fn expansions_are_lights_if_they_are_radiance() {
    let dir = Dir::new();
    let light = ShVec::constant(2, Rgb::new(1.0, 1.0, 1.0));
    dir.sh("light.sh.json", Quantity::Radiance, light.clone());
    dir.sh("wrong.sh.json", Quantity::Irradiance, light);
    let args = format!("{INSIDE} --size 4x4 -o a.exr");
    dir.lobe(&format!("render irradiance built-in:furnace --env light.sh.json {args}")).arg("--quiet").stdout();
    assert!(pixels(&dir, "a.exr").2.iter().all(|p| (p.g - 1.0).abs() < 1e-6), "radiance 1 on walls of albedo 1");
    let line =
        dir.lobe(&format!("render irradiance built-in:furnace --env wrong.sh.json {args}")).arg("--quiet").error();
    assert!(line.starts_with("wrong.sh.json: expected radiance, found irradiance"), "{line}");
}

#[test]
fn what_cannot_be_rendered_is_said_in_one_line() {
    let dir = Dir::new();
    write_even(&dir);
    dir.map("nan.exr", 4, 2, |_, _| [f32::NAN; 3]);
    for (args, part) in [
        ("trace built-in:teapot --env even.exr -o a.png", "there is no such scene in the program"),
        ("trace missing.glb --env even.exr -o a.png", "missing.glb: no such file"),
        ("trace built-in:ball --env nan.exr -o a.png", "row 0; lobe env convert --nonfinite zero makes them black"),
        ("trace built-in:ball --env missing.exr -o a.png", "missing.exr: no such file"),
        ("trace built-in:ball --env even.exr -o a.jpg", "-o: expected a name that ends in .png or .exr"),
        ("trace built-in:ball --env even.exr -o no/a.png", "no"),
        ("built-in:ball --env even.exr --mode shadowed --bounces 2 -o a.png", "--bounces: only of --mode"),
        (
            "built-in:ball --env even.exr --lobe ggx:0.3 --surfaces gltf -o a.png",
            "glossy transfer has the lobe of --lobe",
        ),
        ("built-in:ball --env even.exr --roughness 0.5 -o a.png", "--roughness: matte surfaces have none"),
        ("built-in:ball --env even.exr --mode shadowed --lobe ggx:0.1 -o a.png", "--lobe: only of --mode glossy"),
        ("trcae built-in:ball --env even.exr -o a.png", "unrecognized subcommand 'trcae'"),
        ("built-in:ball --env even.exr --frames 0..2 -o a.png", "--frames A..B: of lobe render moving"),
        ("built-in:ball --env even.exr --mode glossy --lobe ggx:3 -o a.png", "expected phong:E with"),
        ("trace built-in:ball --env even.exr --background sky -o a.png", "expected env, light, none, a color"),
        ("built-in:ball --env even.exr --mode shadowed --order 9 -o a.png", "--order: transfer has an order of 1 to 8"),
        ("trace built-in:ball --env even.exr --target 1,2,3 -o a.png", "--eye"),
        ("trace built-in:ball --env even.exr --orbit 0,91 -o a.png", "--orbit: expected"),
        (
            "trace built-in:ball --env even.exr --eye 1,2,3 --target 1,2,3 -o a.png",
            "expected another point than the target",
        ),
        ("trace built-in:ball --env even.exr --size 0x4 -o a.png", "expected columns x rows"),
        ("trace built-in:ball --env even.exr --fov 180 -o a.png", "below 180 degrees"),
        ("trace built-in:ball --env even.exr --window box -o a.png", "expected hanning"),
        ("built-in:ball --env even.exr --mode magic -o a.png", "possible values: unshadowed"),
    ] {
        let line = dir.lobe(&format!("render {args}")).arg("--quiet").error();
        assert!(line.contains(part), "{args}: {line}");
    }
    assert_eq!(dir.names(), ["even.exr", "nan.exr"], "nothing was written");
}

#[test]
fn a_png_is_the_light_of_the_exr_under_the_tone_curve_and_the_exposure() {
    let dir = Dir::new();
    let args = "render irradiance built-in:cornell --env bundled:sunset --size 16x12 --quiet";
    dir.lobe(&format!("{args} -o light.exr")).stdout();
    let light = read_picture(dir.path("light.exr"), &PictureReadOptions::default()).unwrap().0;
    for curve in Curve::ALL {
        dir.lobe(&format!("{args} --tone {curve} --exposure -1.5 -o a.png")).stdout();
        let tone = Tone { exposure: Exposure::Fixed((-1.5_f64).exp2()), curve };
        assert!(dir.bytes("a.png") == light.to_png(&tone).unwrap(), "{curve}");
    }
}
