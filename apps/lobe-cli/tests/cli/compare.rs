//! `lobe compare`: numbers, exit codes, the test by variance.

use serde_json::Value;

use crate::harness::Dir;

/// Two maps that differ by a tenth in one half.
fn write_two(dir: &Dir) {
    dir.map("a.exr", 16, 8, |x, _| [1.0, if x < 8 { 1.0 } else { 1.1 }, 2.0]);
    dir.map("b.exr", 16, 8, |_, _| [1.0, 1.0, 2.0]);
}

#[test]
fn the_numbers_are_those_of_a_hand_computed_case() {
    let dir = Dir::new();
    write_two(&dir);
    let found: Value = serde_json::from_str(&dir.lobe("compare a.exr b.exr --json").arg("--quiet").stdout()).unwrap();
    let number = |name: &str| found[name].as_f64().unwrap();
    // One of six values differs by 0.1; the peak is 2, the mean 4/3.
    let mse: f64 = 0.01 / 6.0;
    assert!((number("rmse") / mse.sqrt() - 1.0).abs() < 1e-5, "{found}");
    assert!((number("psnr") - 20.0 * (2.0 / mse.sqrt()).log10()).abs() < 1e-4, "{found}");
    assert!((number("relmse") / (mse / (1.0 + 0.01 * 16.0 / 9.0)) - 1.0).abs() < 1e-5, "{found}");
    assert!(number("flip") > 0.005 && number("flip") < 0.2, "{found}");
    assert_eq!(found.as_object().unwrap().len(), 4, "{found}");
    let text = dir.lobe("compare a.exr b.exr").arg("--quiet").stdout();
    assert!(text.starts_with("rmse    0.040825\n") && text.contains("\npsnr    33.802 dB\n"), "{text}");
}

#[test]
fn equal_pictures_have_no_error_and_no_psnr() {
    let dir = Dir::new();
    write_two(&dir);
    let found: Value =
        serde_json::from_str(&dir.lobe("compare a.exr a.exr --json --max 0").arg("--quiet").stdout()).unwrap();
    assert_eq!((&found["rmse"], &found["flip"], &found["psnr"]), (&0.0.into(), &0.0.into(), &Value::Null), "{found}");
}

#[test]
fn what_is_too_far_off_exits_with_1() {
    let dir = Dir::new();
    write_two(&dir);
    for (options, code) in [
        ("--max 0.05", 0),
        ("--max 0.04", 1),
        ("--metric rmse --max 0.04", 1),
        ("--metric psnr --max 30", 0),
        ("--metric psnr --max 40", 1),
        ("--metric flip --max 0", 1),
        ("--metric flip --max 1", 0),
        ("--metric relmse --max 0.01", 0),
        ("", 0),
    ] {
        let output = dir.lobe(&format!("compare a.exr b.exr {options}")).output();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), stderr.as_str()), (Some(code), ""), "{options}");
    }
}

#[test]
fn the_difference_is_a_picture() {
    let dir = Dir::new();
    write_two(&dir);
    dir.lobe("compare a.exr b.exr -o diff.png").arg("--quiet").stdout();
    assert_eq!(&dir.bytes("diff.png")[1..4], b"PNG", "difference");
    let found: Value =
        serde_json::from_str(&dir.lobe("compare diff.png diff.png --json").arg("--quiet").stdout()).unwrap();
    assert_eq!(found["flip"], 0.0, "pictures for displays are read, too");
}

#[test]
fn what_cannot_be_compared_is_said_in_one_line() {
    let dir = Dir::new();
    write_two(&dir);
    dir.map("c.exr", 8, 4, |_, _| [1.0; 3]);
    dir.map("nan.exr", 16, 8, |_, _| [f32::NAN; 3]);
    dir.file("broken.exr", b"no picture");
    for (args, part) in [
        ("a.exr c.exr", "a.exr and c.exr: cannot compare a 16 x 8 picture with one of 8 x 4"),
        ("a.exr missing.exr", "missing.exr: no such file"),
        ("a.exr broken.exr", "broken.exr: "),
        ("a.exr nan.exr", "nan.exr: 128 texels are NaN or infinite, first at column 0, row 0; only numbers can"),
        ("a.exr b.exr -o diff.jpg", "-o: expected a name that ends in .png"),
        ("a.exr b.exr --metric flip", "--max"),
        ("a.exr b.exr --z-test", "a.exr: expected channels variance.R, .G and .B, found none"),
        ("a.exr b.exr --max nan", "expected a finite number"),
        ("a.exr b.exr --pixels-per-degree 5000", "expected 1 to 1000 pixels per degree"),
        ("a.exr", "<B>"),
    ] {
        let line = dir.lobe(&format!("compare {args}")).arg("--quiet").error();
        assert!(line.contains(part), "{args}: {line}");
    }
}

#[test]
fn variances_of_too_few_paths_name_the_picture_and_the_option() {
    let dir = Dir::new();
    for (name, samples) in [("few.exr", 5), ("enough.exr", 6)] {
        let trace = format!("render trace built-in:ball --env bundled:studio --size 8x6 --samples {samples}");
        dir.lobe(&format!("{trace} --bounces 0 -o {name}")).arg("--quiet").stdout();
    }
    let line = dir.lobe("compare enough.exr few.exr --z-test").error();
    let expected = "few.exr: expected a variance of at least 5 degrees of freedom, found 4; lobe render --samples 6 or more gives it";
    assert_eq!(line, expected, "five paths");
    dir.lobe("compare enough.exr enough.exr --z-test").succeeds();
}

#[test]
fn traced_pictures_of_one_light_pass_the_test_and_of_another_do_not() {
    let dir = Dir::new();
    let trace = |name: &str, options: &str| {
        let common = "--env bundled:studio --size 40x30 --samples 64 --bounces 1";
        dir.lobe(&format!("render trace built-in:ball {common} {options} -o {name}")).arg("--quiet").stdout();
    };
    trace("a.exr", "--seed 1 --order 4");
    trace("b.exr", "--seed 2 --order 4");
    trace("c.exr", "--seed 3 --order 4 --rotate-light 20");
    let passes = dir.lobe("compare a.exr b.exr --z-test").arg("--quiet").stdout();
    assert!(passes.contains("z-test  green"), "{passes}");
    let output = dir.lobe("compare a.exr c.exr --z-test --json").output();
    assert_eq!(output.status.code(), Some(1), "another light");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(found["z_test"]["p_spread"][1].as_f64().unwrap() < 1e-6, "{found}");
}

#[test]
fn errors_over_surfaces_have_no_noise_of_the_reference_and_no_background() {
    let dir = Dir::new();
    let trace = |name: &str, samples: u32, seed: u32| {
        let common = "render trace built-in:ball --env bundled:studio --order 4 --size 96x72 --bounces 1";
        dir.lobe(&format!("{common} --samples {samples} --seed {seed} -o {name}")).arg("--quiet").stdout();
    };
    trace("good.exr", 512, 1);
    trace("a.exr", 32, 2);
    trace("b.exr", 32, 3);
    let text = dir.lobe("compare good.exr a.exr --half b.exr --json").arg("--quiet").stdout();
    let found: Value = serde_json::from_str(&text).unwrap();
    let surfaces = &found["surfaces"];
    let number = |name: &str| surfaces[name].as_f64().unwrap();
    assert!(number("noise") > 0.04, "32 paths are noisy: {surfaces}");
    assert!(number("relative_rms") < 0.5 * number("noise"), "512 are not, and the others do not count: {surfaces}");
    assert!((number("mean_ratio") - 1.0).abs() < 0.03 && number("dark") == 0.0, "{surfaces}");
    assert!(number("pixels") > 100.0 && number("pixels") < 96.0 * 72.0, "surfaces alone: {surfaces}");
    let text = dir.lobe("compare good.exr a.exr --half b.exr").arg("--quiet").stdout();
    assert!(text.contains("surfaces: rms "), "{text}");
    let status = |max: f64| {
        let words = format!("compare good.exr a.exr --half b.exr --metric surfaces --max {max}");
        dir.lobe(&words).output().status.code()
    };
    assert_eq!((status(0.5), status(1e-9)), (Some(0), Some(1)), "bounds");
    for (words, expected) in [
        ("good.exr a.exr --half a.exr", "a.exr: expected another --seed than that of a.exr, found the same"),
        (
            "good.exr a.exr --metric surfaces --max 1",
            "--metric surfaces: expected --half B2, another reference of a different --seed",
        ),
    ] {
        assert_eq!(dir.lobe(&format!("compare {words}")).arg("--quiet").error(), expected, "{words}");
    }
}
