//! `lobe sh encodings`: small encodings of irradiance beside the truth.

use std::f64::consts::PI;

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
    assert_eq!(rows.len(), 18, "rows");
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
