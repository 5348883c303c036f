//! `lobe env`: facts and pictures of environment maps.

use std::f32::consts::PI;

use lobe::env::EnvMap;
use lobe::sh::expansion::Quantity;
use lobe::sh::{Rgb, ShVec, project};

use crate::harness::{Dir, ONE, flat_hdr};

fn read(dir: &Dir, name: &str) -> EnvMap {
    EnvMap::load(dir.path(name)).unwrap()
}

/// Asserts that every texel of `map` is `expected`, to a relative error.
fn assert_constant(map: &EnvMap, expected: f32, tolerance: f32, what: &str) {
    for texel in map.texels() {
        let worst = texel.to_array().into_iter().map(|c| (c / expected - 1.0).abs()).fold(0.0, f32::max);
        assert!(worst < tolerance, "{what}: {texel:?} against {expected}");
    }
}

#[test]
fn info_prints_facts() {
    let dir = Dir::new();
    dir.map("sky.exr", 4, 2, |x, y| [x as f32, y as f32 - 0.5, 2.0]);
    let (stdout, stderr) = dir.lobe("env info sky.exr").succeeds();
    let expected = "format     OpenEXR\nsize       4 x 2\nlevels     1\nmapping    lat-long\nmean       1.5 0.0 2.0\n\
                    min        0.0 -0.5 2.0\nmax        3.0 0.5 2.0\nnonfinite  0\nnegative   4\n";
    assert_eq!(stdout, expected, "facts");
    assert_eq!(
        stderr,
        "note: sky.exr: 4 texels are negative in some channel; kept (lobe env adjust --non-negative makes them black)\n",
        "note"
    );
}

#[test]
fn info_prints_json_for_machines() {
    let dir = Dir::new();
    dir.map("sky.exr", 4, 2, |x, y| if x + y == 0 { [f32::NAN; 3] } else { [1.5, 0.1, 2.0] });
    let (stdout, stderr) = dir.lobe("env info sky.exr --json").succeeds();
    let info: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    let keys: Vec<&String> = info.as_object().unwrap().keys().collect();
    let mut expected =
        ["format", "levels", "width", "height", "mapping", "mean", "min", "max", "nonfinite", "negative"];
    expected.sort_unstable();
    assert_eq!(keys, expected, "keys");
    assert!(
        stdout.ends_with("\"min\":[0.0,0.0,0.0],\"max\":[1.5,0.1,2.0],\"nonfinite\":1,\"negative\":0}\n"),
        "{stdout}"
    );
    assert!(stderr.contains("1 texel is NaN or infinite, first at column 0, row 0; read as black"), "{stderr}");
}

#[test]
fn no_map_is_replaced_by_what_is_made_of_it() {
    let dir = Dir::new();
    dir.map("sky.exr", 16, 8, |x, y| [x as f32, y as f32, 1.0]);
    let before = std::fs::read(dir.path("sky.exr")).unwrap();
    for command in [
        "rotate sky.exr --axis 0,0,1 --angle 90",
        "adjust sky.exr --exposure 1",
        "convert sky.exr --to octahedral",
        "sun sky.exr",
        "irradiance sky.exr --size 4",
    ] {
        let line = dir.lobe(&format!("env {command} -o sky.exr")).error();
        assert!(line.ends_with("is an input, which would be lost; give another name"), "{command}: {line}");
        assert_eq!(std::fs::read(dir.path("sky.exr")).unwrap(), before, "{command}");
    }
    // A file is known by its content.
    std::fs::copy(dir.path("sky.exr"), dir.path("sky.png")).unwrap();
    let line = dir.lobe("env show sky.png -o sky.png").error();
    assert!(line.ends_with("is an input, which would be lost; give another name"), "show: {line}");
    dir.lobe("env convert sky.exr --to cube -o face%.exr").stdout();
    let line = dir.lobe("env convert face%.exr --to cube -o face%.exr").error();
    assert!(line.ends_with("is an input, which would be lost; give another name"), "faces: {line}");
}

#[test]
fn both_methods_give_pi_under_a_constant_sky() {
    let dir = Dir::new();
    dir.file("one.hdr", flat_hdr(128, 64, &[ONE; 128 * 64]));
    dir.lobe("env irradiance one.hdr -o sh.exr --size 4").stdout();
    assert_constant(&read(&dir, "sh.exr"), PI, 1e-6, "sh");
    // The texels that the horizon cuts: up to (π/64)².
    dir.lobe("env irradiance one.hdr -o sum.exr --size 4 --method brute-force").stdout();
    assert_constant(&read(&dir, "sum.exr"), PI, 2.5e-3, "brute force");
    assert_eq!((read(&dir, "sh.exr").width(), read(&dir, "sh.exr").height()), (8, 4), "size");
}

#[test]
fn the_irradiance_of_given_normals_is_printed_and_is_that_of_the_picture() {
    let dir = Dir::new();
    dir.map("sky.exr", 64, 32, |_, y| if y < 16 { [1.0, 2.0, 0.0] } else { [0.0; 3] });
    for method in ["--order 9", "--method brute-force"] {
        let args = format!("env irradiance sky.exr --dir 0,0,5 --dir 1,0,0 {method}");
        let values = |text: &str| text.split_whitespace().map(|x| x.parse::<f64>().unwrap()).collect::<Vec<_>>();
        let printed = values(&dir.lobe(&args).stdout());
        let expected = [PI, 2.0 * PI, 0.0, 0.5 * PI, PI, 0.0].map(f64::from);
        for (found, expected) in printed.iter().zip(expected) {
            assert!((found - expected).abs() < 0.02, "{method}: {printed:?}, expected {expected:?}");
        }
        let json = dir.lobe(&format!("{args} --json -o e.exr")).stdout();
        assert!(json.starts_with("{\"values\":[[") && printed.len() == 6, "{json}");
        assert_eq!(read(&dir, "e.exr").height(), 64, "the picture, too");
    }
    assert!(dir.lobe("env irradiance sky.exr").error().contains("--output"), "nothing to do");
    let line = dir.lobe("env irradiance sky.exr --dir 0,0,1 --size 8").error();
    assert!(line.contains("--output"), "a size of no picture: {line}");
}

#[test]
fn the_irradiance_brightens_towards_the_light() {
    let dir = Dir::new();
    // The sun in the top left quarter: up, and at the left of the center, which is +y.
    dir.map("sun.exr", 64, 32, |x, y| if (x, y) == (16, 8) { [1000.0; 3] } else { [0.0; 3] });
    for method in ["--order 3", "--method brute-force"] {
        dir.lobe(&format!("env irradiance sun.exr -o e.exr --size 8 {method}")).stdout();
        let e = read(&dir, "e.exr");
        let brightest = (0..128).max_by(|a, b| e.texels()[*a].r.total_cmp(&e.texels()[*b].r)).unwrap();
        let s = e.dir(brightest % 16, brightest / 16);
        assert!(s.y() > 0.5 && s.z() > 0.3, "{method}: brightest towards {s:?}");
    }
}

#[test]
fn a_reconstruction_has_the_values_of_the_expansion() {
    let dir = Dir::new();
    let f = project(2, 1, |s| Rgb::new(2.0 + s.x(), 2.0 + s.y(), 2.0 + s.z()));
    dir.sh("p.sh.json", Quantity::Radiance, f);
    for name in ["r.exr", "r.hdr"] {
        dir.lobe(&format!("env reconstruct p.sh.json -o {name} --size 16")).stdout();
        let map = read(&dir, name);
        assert_eq!((map.width(), map.height()), (32, 16), "size of {name}");
        for (x, y) in [(0, 0), (16, 8), (24, 7), (31, 15)] {
            let (s, texel) = (map.dir(x, y), map.texel(x, y));
            let error = [2.0 + s.x() - f64::from(texel.r), 2.0 + s.z() - f64::from(texel.b)].map(f64::abs);
            assert!(error.iter().all(|e| *e < 0.02), "{name} at {x}, {y}: {texel:?} towards {s:?}");
        }
    }
}

#[test]
fn a_png_is_tone_mapped_and_says_so() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, ShVec::constant(2, Rgb::new(1.0, 2.0, 3.0)));
    let (stdout, stderr) = dir.lobe("env reconstruct p.sh.json -o r.png --size 8").succeeds();
    assert_eq!(stdout, "", "stdout");
    assert!(stderr.starts_with("note: r.png: tone-mapped by reinhard, exposure -"), "{stderr}");
    assert!(dir.bytes("r.png").starts_with(b"\x89PNG\r\n\x1a\n"), "no PNG");
    assert_eq!(dir.lobe("env reconstruct p.sh.json -o r.png --size 8 --quiet").stdout(), "", "quiet");
}

#[test]
fn a_pfm_holds_the_values_from_the_bottom_up() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, project(2, 1, |s| Rgb::new(s.z(), 0.0, 1.0)));
    dir.lobe("env reconstruct p.sh.json -o r.pfm --size 2").stdout();
    let bytes = dir.bytes("r.pfm");
    let (head, floats) = bytes.split_at("PF\n4 2\n-1.0\n".len());
    assert_eq!(head, b"PF\n4 2\n-1.0\n", "head");
    let first = floats.chunks_exact(4).next().map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let expected = -std::f32::consts::FRAC_1_SQRT_2;
    assert!(first.is_some_and(|first| (first - expected).abs() < 1e-6), "{first:?} against {expected}");
    assert_eq!(floats.len(), 4 * 2 * 3 * 4, "bytes");
}

#[test]
fn what_a_format_cannot_hold_is_noted() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, ShVec::constant(1, -1.0));
    let (_, stderr) = dir.lobe("env reconstruct p.sh.json -o r.hdr --size 1").succeeds();
    let expected = "note: r.hdr: 2 texels are outside of what this format holds and moved into it; .exr holds all\n";
    assert_eq!(stderr, expected, "note");
    let (_, stderr) = dir.lobe("env reconstruct p.sh.json -o r.png --size 1").succeeds();
    assert!(stderr.contains("note: r.png: 100.00 % of its pixels are below zero and black"), "{stderr}");
}

#[test]
fn other_extensions_are_refused_before_any_work() {
    let dir = Dir::new();
    for name in ["r.jpg", "r", "-"] {
        let line = dir.lobe(&format!("env irradiance bundled:studio -o {name}")).error();
        assert!(line.contains("expected a name that ends in .exr, .hdr, .pfm or .png"), "{name}: {line}");
    }
    let line = dir.lobe("env irradiance bundled:studio -o e.exr --order 3 --method brute-force").error();
    assert!(line.starts_with("--order: --method brute-force has no order"), "{line}");
    assert_eq!(dir.names(), [""; 0], "files");
}
