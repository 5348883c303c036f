//! `lobe sh encode` and `lobe sh encodings`: small encodings of irradiance beside the truth.

use std::f64::consts::PI;

use lobe::env::{EnvMap, irradiance_sh};
use lobe::sh::encoding::{IrradianceEncoding, IrradianceMatrix, PackedIrradiance};
use lobe::sh::expansion::Quantity;
use lobe::sh::{Coefficient as _, Dir as Direction, Expansion as _, Rgb, ShVec, Zonal, eval_basis};
use lobe_testkit::directions;
use serde_json::Value;

use crate::harness::{Dir, ONE, flat_hdr};

fn json(dir: &Dir, args: &str) -> Value {
    serde_json::from_str(&dir.lobe(args).stdout()).unwrap()
}

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} of {row} is no number"))
}

#[test]
fn a_white_sky_is_kept_by_all_that_have_a_constant() {
    let dir = Dir::new();
    dir.file("one.hdr", flat_hdr(128, 64, &[ONE; 128 * 64]));
    let found = json(&dir, "sh encodings one.hdr --json");
    // The sum over the pixels is wrong by up to (π/64)² where the horizon cuts them.
    assert!((number(&found, "mean") / PI - 1.0).abs() < 2.5e-3, "mean {}", found["mean"]);
    for row in found["encodings"].as_array().unwrap() {
        let (rms, lowest) = (number(row, "rms"), number(row, "lowest"));
        if row["name"] == "hl2-linear" {
            assert!(rms > 0.3, "it has no constant: {row}");
            continue;
        }
        assert!(rms < 2.5e-3 && (lowest / PI - 1.0).abs() < 1e-6, "{row}");
    }
}

#[test]
fn a_lamp_orders_the_encodings_as_their_numbers_do() {
    let dir = Dir::new();
    dir.map("lamp.exr", 64, 32, |x, y| if (x, y) == (40, 9) { [3000.0, 2000.0, 1000.0] } else { [0.1, 0.2, 0.4] });
    let found = json(&dir, "sh encodings lamp.exr --json");
    let rms = |name: &str| {
        let rows = found["encodings"].as_array().unwrap();
        let row = rows.iter().find(|row| row["name"] == name).unwrap_or_else(|| panic!("{name} is missing"));
        number(row, "rms")
    };
    for (better, worse) in [
        ("sh-3", "sh-2"),
        ("sh-5", "sh-3"),
        ("zh3", "zh3-hallucinated"),
        ("zh3-hallucinated", "sh-2"),
        ("ambient-cube", "ambient-cube-axes"),
        ("h-6", "h-4"),
        ("sh-3-hemisphere", "sh-3"),
        // A constant and a lamp is what it holds.
        ("ahd", "sh-3"),
    ] {
        assert!(rms(better) < rms(worse), "{better} {} against {worse} {}", rms(better), rms(worse));
    }
}

#[test]
fn the_table_names_every_encoding_once_and_is_the_same_for_any_number_of_threads() {
    let dir = Dir::new();
    dir.map("sky.exr", 32, 16, |x, y| [x as f32, y as f32, 1.0]);
    let text = dir.lobe("sh encodings sky.exr --threads 1").stdout();
    assert_eq!(dir.lobe("sh encodings sky.exr --threads 3").stdout(), text, "threads");
    let found = json(&dir, "sh encodings sky.exr --json");
    let rows = found["encodings"].as_array().unwrap();
    assert_eq!(rows.len(), IrradianceEncoding::ALL.len(), "rows");
    for row in rows {
        let line = format!("{:<30}{:>6}", row["name"].as_str().unwrap(), row["floats"].as_u64().unwrap());
        assert_eq!(text.lines().filter(|l| l.starts_with(&line)).count(), 1, "{line:?} in\n{text}");
    }
}

#[test]
fn a_black_sky_has_no_relative_error_and_a_missing_one_no_table() {
    let dir = Dir::new();
    dir.map("black.exr", 8, 4, |_, _| [0.0; 3]);
    let found = json(&dir, "sh encodings black.exr --json");
    assert!(found["mean"] == 0.0 && found["encodings"][0]["rms"].is_null(), "{found}");
    let error = dir.lobe("sh encodings nowhere.exr").error();
    assert!(error.contains("nowhere.exr"), "{error}");
}

/// The rows that `lobe sh encode` prints, by name.
fn encoded(dir: &Dir, args: &str) -> Vec<(String, Vec<f64>)> {
    let found = json(dir, &format!("sh encode {args} --json"));
    let row = |row: &Value| {
        let values = row["values"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        (row["name"].as_str().unwrap().to_owned(), values)
    };
    found["numbers"].as_array().unwrap().iter().map(row).collect()
}

fn radiance() -> ShVec<Rgb<f64>> {
    let sun = ShVec::impulse(5, Direction::from_angles(1.0, 2.0), Rgb::new(3.0, 2.0, 1.0));
    &sun + &ShVec::constant(5, Rgb::new(0.2, 0.4, 0.8))
}

#[test]
fn constants_of_shaders_give_the_irradiance_of_every_normal() {
    let dir = Dir::new();
    let irradiance = radiance().convolved(&Zonal::clamped_cosine(5));
    dir.sh("l.sh.json", Quantity::Radiance, radiance());
    dir.sh("e.sh.json", Quantity::Irradiance, irradiance.clone());
    for file in ["l.sh.json", "e.sh.json"] {
        let packed = encoded(&dir, &format!("{file} --as packed"));
        let names: Vec<&str> = packed.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["cAr", "cAg", "cAb", "cBr", "cBg", "cBb", "cC"], "{file}");
        let matrix = encoded(&dir, &format!("{file} --as matrix"));
        for v in directions() {
            let [x, y, z] = v;
            let expected = PackedIrradiance::from_irradiance_sh(&irradiance).eval(Direction::from_unit(v)).to_array();
            let by_matrix = IrradianceMatrix::from_irradiance_sh(&irradiance).eval(Direction::from_unit(v)).to_array();
            let sum = |a: &[f64], b: [f64; 4]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            for c in 0..3 {
                let linear = sum(&packed[c].1, [x, y, z, 1.0]);
                let quadratic = sum(&packed[3 + c].1, [x * y, y * z, z * z, z * x]);
                let found = linear + quadratic + packed[6].1[c] * (x * x - y * y);
                assert!((found - expected[c]).abs() < 1e-12, "{file}, packed towards {v:?}: {found} {expected:?}");
                let n = [x, y, z, 1.0];
                let found: f64 = (0..4).map(|i| n[i] * sum(&matrix[c].1[4 * i..4 * i + 4], n)).sum();
                assert!((found - by_matrix[c]).abs() < 1e-12, "{file}, matrix towards {v:?}: {found} {by_matrix:?}");
                assert!((found - expected[c]).abs() < 1e-12, "the two forms agree towards {v:?}");
            }
        }
    }
}

/// Light of high contrast, all of whose numbers are exact in 16 bits.
fn lamp(x: usize, y: usize) -> [f32; 3] {
    if (x, y) == (40, 9) { [2048.0, 1024.0, 512.0] } else { [0.125, 0.25, 0.5] }
}

#[test]
fn vectors_of_order_5_give_its_irradiance_to_every_normal() {
    let dir = Dir::new();
    dir.map("lamp.exr", 64, 32, lamp);
    let texels = (0..64 * 32).map(|i| Rgb::from(lamp(i % 64, i / 64))).collect();
    let map = EnvMap::new(64, 32, texels).unwrap();
    let irradiance = irradiance_sh(&map, 5);
    dir.lobe("project lamp.exr -o l.sh.json --order 5").stdout();
    let packed = encoded(&dir, "l.sh.json --as packed-5");
    let names: Vec<&str> = packed.iter().map(|(name, _)| name.as_str()).collect();
    let expected = ["cAr", "cAg", "cAb", "cBr", "cBg", "cBb", "cC", "cDr", "cDg", "cDb", "cFr", "cFg", "cFb", "cG"];
    assert_eq!(names, expected, "the order of the vectors");
    let bands = encoded(&dir, "l.sh.json --as sh-5");
    let of_coefficients = |n: Direction, c: usize| {
        let y = eval_basis(n, 5);
        let index = |name: &str| name.strip_prefix("E_").and_then(|i| i.parse::<usize>().ok()).unwrap();
        bands.iter().map(|(name, values)| values[c] * y[index(name)]).sum::<f64>()
    };
    let unit = irradiance.eval(Direction::Z).r;
    for v in directions() {
        let [x, y, z] = v;
        let (quadratic, d) = ([x * y, y * z, z * z, z * x], x * x - y * y);
        let expected = irradiance.eval(Direction::from_unit(v)).to_array();
        for c in 0..3 {
            let vector = |first: usize, k: usize| packed[first + c].1[k];
            let linear: f64 = [x, y, z, 1.0].into_iter().enumerate().map(|(k, s)| s * vector(0, k)).sum();
            let quartic = quadratic.iter().enumerate();
            let quartic: f64 =
                quartic.map(|(k, q)| q * (vector(3, k) + z * z * vector(7, k) + d * vector(10, k))).sum();
            let found = linear + quartic + (packed[6].1[c] + d * packed[13].1[c]) * d;
            let by_bands = of_coefficients(Direction::from_unit(v), c);
            for (what, found) in [("vectors", found), ("bands", by_bands)] {
                let off = (found - expected[c]).abs();
                assert!(off < 1e-5 * unit, "{what} towards {v:?}: {found} against {expected:?}");
            }
            assert!((found - by_bands).abs() < 1e-12 * unit, "the two forms agree towards {v:?}");
        }
    }
}

#[test]
fn nine_coefficients_of_ramamoorthi_and_hanrahan_give_irradiance_by_their_formula() {
    let dir = Dir::new();
    let irradiance = radiance().convolved(&Zonal::clamped_cosine(3));
    dir.sh("l.sh.json", Quantity::Radiance, radiance());
    dir.sh("e.sh.json", Quantity::Irradiance, irradiance.clone());
    let (c1, c2) = (0.429042765404892, 0.511663353973244);
    let (c3, c4, c5) = (0.743123868301127, 0.886226925452758, 0.247707956100376);
    for file in ["l.sh.json", "e.sh.json"] {
        let rows = encoded(&dir, &format!("{file} --as r-h"));
        let names: Vec<&str> = rows.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["L00", "L1-1", "L10", "L11", "L2-2", "L2-1", "L20", "L21", "L22"], "{file}");
        for v in directions() {
            let [x, y, z] = v;
            let expected = irradiance.eval(Direction::from_unit(v)).to_array();
            for c in 0..3 {
                let l = |i: usize| rows[i].1[c];
                let found = c1 * l(8) * (x * x - y * y) + c3 * l(6) * z * z + c4 * l(0) - c5 * l(6)
                    + 2.0 * c1 * (l(4) * x * y + l(7) * x * z + l(5) * y * z)
                    + 2.0 * c2 * (l(3) * x + l(1) * y + l(2) * z);
                assert!((found - expected[c]).abs() < 1e-12, "{file} towards {v:?}: {found} {expected:?}");
            }
        }
    }
    dir.sh("x.sh.json", Quantity::Radiance, ShVec::impulse(2, Direction::X, 1.0));
    let rows = encoded(&dir, "x.sh.json --as r-h");
    assert!(rows[3].1.iter().all(|l| *l > 0.0), "L11 of light from +x is positive: {rows:?}");
}

#[test]
fn constants_can_be_those_of_white_surfaces_in_worlds_with_y_up() {
    let dir = Dir::new();
    dir.sh("l.sh.json", Quantity::Radiance, radiance());
    let irradiance = radiance().convolved(&Zonal::clamped_cosine(3));
    let packed = encoded(&dir, "l.sh.json --as packed --over-pi --up y");
    for v in directions() {
        // The same place in a world with y up.
        let [x, y, z] = [v[0], v[2], -v[1]];
        let expected = irradiance.eval(Direction::from_unit(v)).scale(1.0 / PI).to_array();
        for c in 0..3 {
            let [a, b] = [&packed[c].1, &packed[3 + c].1];
            let found = a[0] * x
                + a[1] * y
                + a[2] * z
                + a[3]
                + (b[0] * x * y + b[1] * y * z + b[2] * z * z + b[3] * z * x)
                + packed[6].1[c] * (x * x - y * y);
            assert!((found - expected[c]).abs() < 1e-12, "towards {v:?}: {found} {expected:?}");
        }
    }
    dir.sh("white.sh.json", Quantity::Radiance, ShVec::constant(3, 1.0));
    let text = dir.lobe("sh encode white.sh.json --as sh-2 --over-pi --up y").stdout();
    assert!(text.starts_with("sh-2, 4 floats, of E/pi, y up\n"), "{text}");
}

#[test]
fn every_encoding_prints_as_many_numbers_as_it_takes() {
    let dir = Dir::new();
    dir.sh("l.sh.json", Quantity::Radiance, radiance());
    for encoding in IrradianceEncoding::ALL {
        let name = encoding.name();
        let normal = if encoding.is_hemispherical() { "--normal 0,1,0" } else { "" };
        let rows = encoded(&dir, &format!("l.sh.json --as {name} {normal}"));
        let count: usize = rows.iter().map(|(_, values)| values.len()).sum();
        // The zonal number of a hallucinated ZH3 follows from the others.
        let derived = if matches!(encoding, IrradianceEncoding::Zh3Hallucinated(_)) { 3 } else { 0 };
        assert_eq!(count, encoding.floats(3) + derived, "{name}: {rows:?}");
        let text = dir.lobe(&format!("sh encode l.sh.json --as {name}")).stdout();
        assert!(text.starts_with(&format!("{name}, {} floats, of E, z up\n", encoding.floats(3))), "{text}");
    }
    let one = ShVec::constant(3, PI);
    dir.sh("one.sh.json", Quantity::Irradiance, one);
    let cube = encoded(&dir, "one.sh.json --as ambient-cube");
    assert!(cube.len() == 6 && cube.iter().all(|(_, v)| (v[0] - PI).abs() < 1e-12), "a white sky: {cube:?}");
    let error = dir.lobe("sh encode one.sh.json --as zh4").error();
    assert!(
        error.contains("r-h, three, babylon, playcanvas, filament, godot, unity, unreal, cesium or one of sh-2, "),
        "{error}"
    );
    dir.sh("v.sh.json", Quantity::Visibility, ShVec::constant(3, 1.0));
    let error = dir.lobe("sh encode v.sh.json --as packed").error();
    assert_eq!(error, "v.sh.json: expected radiance or irradiance, found visibility", "visibility");
}

#[test]
fn a_normal_is_refused_where_it_has_no_meaning() {
    let dir = Dir::new();
    dir.sh("l.sh.json", Quantity::Radiance, radiance());
    let encodings = IrradianceEncoding::ALL.into_iter().filter(|encoding| !encoding.is_hemispherical());
    for name in encodings.map(IrradianceEncoding::name).chain(["packed", "packed-5", "matrix", "r-h"]) {
        let error = dir.lobe(&format!("sh encode l.sh.json --as {name} --normal 0,1,0")).error();
        let expected = "--normal: only of encodings of one side of a surface, such as h-4; leave the option out";
        assert_eq!(error, expected, "{name}");
    }
    let [up, unsaid] = ["--normal 0,0,1", ""].map(|normal| encoded(&dir, &format!("l.sh.json --as h-4 {normal}")));
    assert_eq!(up, unsaid, "without it the surface faces up");
}

#[test]
fn order_5_of_fewer_bands_is_noted_and_coefficients_of_light_are_called_so() {
    let dir = Dir::new();
    dir.map("sky.exr", 16, 8, |x, y| [1.0 + x as f32, 2.0, 3.0 + y as f32]);
    for (order, is_noted) in [(3, true), (5, false)] {
        dir.lobe(&format!("project sky.exr --order {order} -o s.sh.json")).succeeds();
        for form in ["packed-5", "sh-5"] {
            let (_, note) = dir.lobe(&format!("sh encode s.sh.json --as {form}")).succeeds();
            assert_eq!(
                note.contains("the numbers of its fifth band are zero"),
                is_noted,
                "{form}, order {order}: {note}"
            );
        }
    }
    for (option, of) in [("", "L"), (" --over-pi", "L/pi")] {
        let text = dir.lobe(&format!("sh encode s.sh.json --as r-h{option}")).stdout();
        assert!(text.starts_with(&format!("r-h, 27 floats, of {of}, z up\n")), "{text}");
    }
}
