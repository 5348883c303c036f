//! `lobe export`, `lobe import` and `lobe sh encode --as ENGINE`.

use lobe::env::{CubeHandedness, MapReadOptions, read_map};
use lobe::sh::encoding::EngineForm;
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::FileCoefficients;
use lobe::sh::{Expansion as _, Rgb, ShVec, Zonal};

use crate::harness::{Dir, mean};

/// A sky that differs from texel to texel.
fn with_sky() -> Dir {
    let dir = Dir::new();
    dir.map("sky.exr", 32, 16, |x, y| [1.0 + 0.02 * x as f32, 1.0 + 0.03 * y as f32, 0.5 + 0.01 * (x + y) as f32]);
    dir
}

fn radiance() -> ShVec<Rgb<f64>> {
    let number = |k: usize| ((7 * k + 3) % 11) as f64 / 11.0 - 0.4;
    ShVec::from_vec((0..9).map(|i| Rgb::new(number(3 * i), number(3 * i + 1), number(3 * i + 2))).collect()).unwrap()
}

fn colors(dir: &Dir, name: &str) -> ShVec<Rgb<f64>> {
    match dir.read_sh(name).coefficients {
        FileCoefficients::Rgb(f) => f,
        FileCoefficients::Scalar(f) => panic!("{name} has no colors: {f:?}"),
    }
}

fn worst(a: &ShVec<Rgb<f64>>, b: &ShVec<Rgb<f64>>) -> f64 {
    let pairs = a.coefficients().iter().zip(b.coefficients());
    pairs.flat_map(|(a, b)| (*a - *b).to_array()).fold(0.0, |worst, e| worst.max(e.abs()))
}

#[test]
fn a_light_is_exported_for_two_engines_at_once() {
    let dir = with_sky();
    let (stdout, stderr) =
        dir.lobe("export sky.exr --engine three,filament,three -o out --size 32 --suns none").succeeds();
    assert_eq!((stdout.as_str(), stderr.as_str()), ("", ""), "no option is needed and nothing is to be said");
    for name in ["three/specular.ktx2", "three/sky.hdr", "three/sky.mjs", "three/README.md", "filament/sky.ktx"] {
        assert!(dir.path("out").join(name).is_file(), "{name}");
    }
    // The chain is that of the options which three.js needs.
    dir.lobe("env prefilter sky.exr --size 32 --last-size 8 --roughness quadratic --left-handed -o chain.ktx2")
        .succeeds();
    assert!(dir.bytes("out/three/specular.ktx2") == dir.bytes("chain.ktx2"), "the chain of three.js");
    // So is that of Filament, whose own mapping is the usual one of .ktx.
    dir.lobe("env prefilter sky.exr --size 32 -o chain.ktx").succeeds();
    assert!(dir.bytes("out/filament/light.ktx") == dir.bytes("chain.ktx"), "the chain of Filament");
    // That mapping is another than the one of .ktx2.
    let levels = "env prefilter sky.exr --size 32 --last-size 8 -o";
    dir.lobe(&format!("{levels} a.ktx")).succeeds();
    dir.lobe(&format!("{levels} b.ktx --roughness quadratic")).succeeds();
    dir.lobe(&format!("{levels} c.ktx --roughness linear")).succeeds();
    assert!(
        dir.bytes("a.ktx") == dir.bytes("b.ktx") && dir.bytes("a.ktx") != dir.bytes("c.ktx"),
        "quadratic by itself"
    );
    // The numbers are those of the map.
    dir.lobe("project sky.exr --order 3 -o sky.sh.json").succeeds();
    for (file, engine) in [("out/three/light-probe.json", "three"), ("out/filament/light.ktx", "filament")] {
        dir.lobe(&format!("import {file} --from {engine} -o back.sh.json")).stdout();
        let error = worst(&colors(&dir, "back.sh.json"), &colors(&dir, "sky.sh.json"));
        assert!(error < 1e-5, "{file}: {error}");
    }
}

#[test]
fn an_export_that_cannot_be_made_leaves_nothing() {
    let dir = with_sky();
    let said = |args: &str| dir.lobe(args).error();
    assert!(said("export sky.exr --engine quake -o out").contains("possible values: three, babylon,"), "an engine");
    assert!(said("export sky.exr --engine three -o out --size 48").starts_with("--size: faces for engines"), "a size");
    assert!(said("export none.exr --engine three -o out").starts_with("none.exr: no such file"), "a missing map");
    assert!(said("export sky.exr --engine three -o out --suns none.json").contains("none.json"), "missing suns");
    let in_the_way = said("export sky.exr --engine three -o sky.exr");
    assert_eq!(in_the_way, "-o: sky.exr is a file; name a folder", "a file in the place of the folder");
    dir.file("three", "");
    assert!(said("export three --engine three -o .").contains("three"), "a file in the place of an engine's folder");
    assert_eq!(dir.names(), ["sky.exr", "three"], "nothing was written");
}

#[test]
fn forms_of_engines_are_read_back_to_the_last_digits() {
    let dir = Dir::new();
    dir.sh("l.sh.json", Quantity::Radiance, radiance());
    dir.sh("e.sh.json", Quantity::Irradiance, radiance().convolved(&Zonal::clamped_cosine(3)));
    for form in EngineForm::ALL {
        for (input, json) in [("l.sh.json", ""), ("l.sh.json", " --json"), ("e.sh.json", "")] {
            dir.file("n.txt", dir.lobe(&format!("sh encode {input} --as {form}{json}")).stdout());
            assert_eq!(dir.lobe(&format!("import n.txt --from {form} -o back.sh.json")).stdout(), "", "{form}");
            assert_eq!(dir.read_sh("back.sh.json").quantity, Quantity::Radiance, "{form}");
            let error = worst(&colors(&dir, "back.sh.json"), &radiance());
            assert!(error < 1e-14, "{form}, {input}{json}: {error}");
        }
    }
    let text = dir.lobe("sh encode l.sh.json --as unity").stdout();
    assert!(text.starts_with("unity, 27 floats, of E/pi, left-handed, y up\nr "), "{text}");
    for option in ["--over-pi", "--up y"] {
        let error = dir.lobe(&format!("sh encode l.sh.json --as three {option}")).error();
        let name = option.split(' ').next().unwrap();
        assert_eq!(error, format!("{name}: the form of three says it by itself; leave the option out"), "{option}");
    }
    let error = dir.lobe("import l.sh.json --from three -o back.txt").error();
    assert!(error.contains(".sh.json"), "{error}");
    let error = dir.lobe("import - --from three -o -").stdin("1 2 3").error();
    assert_eq!(error, "-: nine colors, 27 numbers, expected, found 3", "too few");
}

#[test]
fn a_cube_of_irradiance_over_pi_is_one_command() {
    let dir = with_sky();
    dir.lobe("env irradiance sky.exr --over-pi --left-handed --size 8 -o d.ktx2").succeeds();
    let (map, report) = read_map(dir.path("d.ktx2"), &MapReadOptions::default()).unwrap();
    assert!(report.told.iter().any(|remark| remark.contains("left-handed")), "{:?}", report.told);
    assert_eq!(CubeHandedness::Left.mapping_name(), Some("cube-left-handed"));
    // The mean of irradiance is π times that of the light.
    let (found, numbers) = (map.base().mean().g, dir.numbers("sky.exr"));
    dir.lobe("env irradiance sky.exr --over-pi --size 8 -o d.exr").succeeds();
    dir.lobe("env irradiance sky.exr --size 8 -o e.exr").succeeds();
    let (over_pi, whole) = (mean(&dir.numbers("d.exr")), mean(&dir.numbers("e.exr")));
    assert!((whole / over_pi - std::f64::consts::PI).abs() < 1e-4, "{whole}, {over_pi}");
    assert!(found > 0.0 && numbers.len() == 3 * 32 * 16, "{found}");
    let values = |args: &str| dir.lobe(&format!("env irradiance sky.exr --dir 0,0,1{args}")).stdout();
    let first = |text: String| text.split_whitespace().next().unwrap().parse::<f64>().unwrap();
    let ratio = first(values("")) / first(values(" --over-pi"));
    assert!((ratio - std::f64::consts::PI).abs() < 1e-12, "{ratio}");
    let error = dir.lobe("env irradiance sky.exr --to cube --method brute-force -o d.exr").error();
    assert!(error.starts_with("--method: brute-force"), "{error}");
}

#[test]
fn one_factor_scales_all_channels() {
    let dir = with_sky();
    dir.lobe("env adjust sky.exr --scale 0.5 -o one.exr").stdout();
    dir.lobe("env adjust sky.exr --scale 0.5,0.5,0.5 -o three.exr").stdout();
    assert_eq!(dir.numbers("one.exr"), dir.numbers("three.exr"), "one number or three");
}
