//! `lobe project`: projections of pictures onto expansions.

use std::f64::consts::PI;

use lobe::sh::expansion::Quantity;
use lobe::sh::{Expansion as _, Rgb, ShVec};

use crate::harness::{Dir, ONE, flat_hdr};

fn projected(dir: &Dir, name: &str) -> ShVec<Rgb<f64>> {
    let file = dir.read_sh(name);
    assert_eq!(file.quantity, Quantity::Radiance, "quantity");
    file.coefficients.to_rgb()
}

#[test]
fn a_constant_picture_has_only_a_mean() {
    let dir = Dir::new();
    dir.file("one.hdr", flat_hdr(16, 8, &[ONE; 128]));
    assert_eq!(dir.lobe("project one.hdr -o p.sh.json --order 5").stdout(), "", "stdout");
    let f = projected(&dir, "p.sh.json");
    assert_eq!(f.order(), 5, "order");
    for (i, c) in f.coefficients().iter().enumerate() {
        let expected = if i == 0 { (4.0 * PI).sqrt() } else { 0.0 };
        assert!((c.g - expected).abs() < 1e-12, "i {i}: {c:?} against {expected}");
    }
}

#[test]
fn pixels_are_radiance_unless_they_are_named() {
    let dir = Dir::new();
    dir.file("one.hdr", flat_hdr(16, 8, &[ONE; 128]));
    dir.lobe("project one.hdr -o p.sh.json --quantity irradiance").stdout();
    assert_eq!(dir.read_sh("p.sh.json").quantity, Quantity::Irradiance, "as it was named");
}

#[test]
fn the_order_is_three_unless_another_is_asked_for() {
    let dir = Dir::new();
    dir.file("one.hdr", flat_hdr(2, 1, &[ONE; 2]));
    dir.lobe("project one.hdr -o p.sh.json").stdout();
    assert_eq!(projected(&dir, "p.sh.json").order(), 3, "order");
}

#[test]
fn the_bundled_map_projects_to_the_mean_that_info_prints() {
    let dir = Dir::new();
    dir.lobe("project bundled:sunset -o p.sh.json --order 6 --quiet").stdout();
    let mean = projected(&dir, "p.sh.json").mean();
    let info: serde_json::Value =
        serde_json::from_str(&dir.lobe("env info bundled:sunset --json --quiet").stdout()).unwrap();
    for (c, mean) in mean.to_array().into_iter().enumerate() {
        let expected = info["mean"][c].as_f64().unwrap();
        assert!((mean - expected).abs() < 1e-6 * expected, "channel {c}: {mean} against {expected}");
    }
}

#[test]
fn the_whole_way_from_a_photograph_to_irradiance_through_pipes() {
    let dir = Dir::new();
    let p = dir.lobe("project bundled:studio -o - --quiet").stdout();
    let e = dir.lobe("sh convolve - --kernel cosine -o -").stdin(p).stdout();
    let values = dir.lobe("sh eval - --dir 0,0,1").stdin(e).stdout();
    let values: Vec<f64> = values.split_whitespace().map(|v| v.parse().unwrap()).collect();
    dir.lobe("env irradiance bundled:studio -o e.exr --method brute-force --size 32 --quiet").stdout();
    let map = lobe::env::EnvMap::load(dir.path("e.exr")).unwrap();
    for (c, value) in values.iter().enumerate() {
        let truth = f64::from(map.texel(0, 0).to_array()[c]);
        // Nine coefficients keep irradiance to a few percent; the first row looks 3 degrees past +z.
        assert!((value / truth - 1.0).abs() < 0.15, "channel {c}: {value} against {truth}");
    }
    assert_eq!(values.len(), 3, "channels");
}

#[test]
fn sampling_finds_what_the_exact_method_finds_and_says_how_well() {
    let dir = Dir::new();
    dir.map("sky.exr", 64, 32, |x, y| [1.0 + x as f32 / 64.0, y as f32 / 32.0, 0.5]);
    dir.lobe("project sky.exr -o exact.sh.json").stdout();
    let exact = projected(&dir, "exact.sh.json");
    for (method, samples) in [("monte-carlo --seed 3", 10000), ("fibonacci", 10000)] {
        let args = format!("project sky.exr -o p.sh.json --samples {samples} --method {method}");
        let (_, stderr) = dir.lobe(&args).succeeds();
        assert!(stderr.starts_with("note: sky.exr: 1") && stderr.contains("standard error"), "{method}: {stderr}");
        for (a, b) in projected(&dir, "p.sh.json").coefficients().iter().zip(exact.coefficients()) {
            let error = (*a - *b).to_array().map(f64::abs);
            assert!(error.iter().all(|e| *e < 0.02), "{method}: {a:?} against {b:?}");
        }
    }
}

#[test]
fn equal_seeds_give_equal_bytes() {
    let dir = Dir::new();
    let run = |seed: u32| {
        dir.lobe(&format!("project bundled:studio -q -o - --method monte-carlo --samples 400 --seed {seed}")).stdout()
    };
    assert_eq!(run(5), run(5), "equal seeds");
    assert_ne!(run(5), run(6), "other seeds");
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let dir = Dir::new();
    for threads in [1, 2] {
        for (command, name) in [
            ("project bundled:sunset --order 9", "p.sh.json"),
            ("env irradiance bundled:sunset --method brute-force --size 8", "e.exr"),
            ("env irradiance bundled:sunset --order 6", "s.pfm"),
        ] {
            dir.lobe(&format!("{command} -q --threads {threads} -o {threads}-{name}")).stdout();
        }
    }
    for name in ["p.sh.json", "e.exr", "s.pfm"] {
        let [one, two] = [1, 2].map(|threads| dir.bytes(&format!("{threads}-{name}")));
        assert!(one == two, "{name} differs between one thread and two");
    }
}

#[test]
fn pixels_that_are_no_numbers_are_refused_or_read_as_black() {
    let dir = Dir::new();
    let texel = |x, y| if (x, y) == (1, 1) || (x, y) == (3, 1) { [f32::NAN, 1.0, f32::INFINITY] } else { [1.0; 3] };
    dir.map("nan.exr", 4, 2, texel);
    let found = "nan.exr: 2 texels are NaN or infinite, first at column 1, row 1";
    let line = dir.lobe("project nan.exr -o p.sh.json").error();
    assert_eq!(line, format!("{found}; --nonfinite zero reads them as black"), "refused");
    let (_, stderr) = dir.lobe("project nan.exr -o p.sh.json --nonfinite zero").succeeds();
    assert_eq!(stderr, format!("note: {found}; read as black\n"), "read");
    let (mean, expected) = (projected(&dir, "p.sh.json").mean(), 0.75);
    assert!((mean.r - expected).abs() < 1e-12, "two of eight texels of equal size are black: {mean:?}");
}

#[test]
fn negative_pixels_are_kept_and_noted() {
    let dir = Dir::new();
    dir.map("minus.exr", 2, 1, |_, _| [-2.0, 0.0, 1.0]);
    let (_, stderr) = dir.lobe("project minus.exr -o p.sh.json").succeeds();
    assert_eq!(
        stderr,
        "note: minus.exr: 2 texels are negative in some channel; kept (lobe env adjust --non-negative makes them black)\n",
        "note"
    );
    let mean = projected(&dir, "p.sh.json").mean();
    assert!((mean.r + 2.0).abs() < 1e-12, "{mean:?}");
}

#[test]
fn options_of_another_method_are_refused() {
    let dir = Dir::new();
    for (options, start) in [
        ("--samples 9", "--samples: every pixel counts with --method exact"),
        ("--seed 9", "--seed: only --method monte-carlo is random"),
        ("--seed 9 --method fibonacci", "--seed: only --method monte-carlo is random"),
    ] {
        let line = dir.lobe(&format!("project bundled:studio -o p.sh.json {options}")).error();
        assert!(line.starts_with(start), "{options}: {line}");
    }
}

/// A rotation about z by whole columns is what moving the columns is, to the rounding of the picture.
#[test]
fn order_256_goes_from_picture_to_picture() {
    const SIZE: [usize; 2] = [128, 64];
    let dir = Dir::new();
    let texel = |x: usize, y: usize| [(x * 7 + y * 3) as f32 % 5.0, 1.0, 0.5];
    dir.map("a.exr", SIZE[0], SIZE[1], texel);
    // The azimuth falls from left to right: 90 degrees are a quarter of the columns to the left.
    dir.map("b.exr", SIZE[0], SIZE[1], |x, y| texel((x + SIZE[0] / 4) % SIZE[0], y));
    dir.lobe("project a.exr --order 256 -o a.sh.json").stdout();
    dir.lobe("project b.exr --order 256 -o b.sh.json").stdout();
    dir.lobe("sh rotate a.sh.json --axis 0,0,1 --angle 90 -o turned.sh.json").stdout();
    let [turned, moved] = ["turned.sh.json", "b.sh.json"].map(|name| dir.read_sh(name).coefficients.to_rgb());
    assert_eq!(turned.order(), 256, "order");
    let error = turned.coefficients().iter().zip(moved.coefficients());
    let error = error.map(|(a, b)| (a.r - b.r).abs()).fold(0.0, f64::max);
    assert!(error < 1e-12, "turned and moved differ by {error:e}");
    dir.lobe("env reconstruct turned.sh.json -o r.exr --size 64").stdout();
    for command in [
        "dering a.sh.json -o c.sh.json",
        "min a.sh.json",
        "peaks a.sh.json",
        "lights a.sh.json",
        "plot a.sh.json -o c.png",
        "window a.sh.json --kind hanning --content -o c.sh.json",
    ] {
        let error = dir.lobe(&format!("sh {command}")).error();
        assert!(error.starts_with("a.sh.json: expected order 64 at most, found 256"), "{command}: {error}");
    }
}
