//! `lobe sh window`, `lobe sh dering`, `lobe sh min`: ringing, its bounds and its removal.

use std::f64::consts::PI;

use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::FileCoefficients;
use lobe::sh::{Coefficient as _, Dir as Direction, Expansion as _, Rgb, ShVec, Zonal};
use lobe_testkit::fibonacci_sphere;
use serde_json::Value;

use crate::harness::Dir;

fn json(dir: &Dir, args: &str) -> Value {
    serde_json::from_str(&dir.lobe(args).stdout()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    let array = value.as_array().unwrap_or_else(|| panic!("{value} is no array"));
    array.iter().map(|x| x.as_f64().unwrap_or_else(|| panic!("{x} of {value} is no number"))).collect()
}

/// An impulse towards +z of peak `n²/4π`.
fn impulse(order: usize) -> ShVec<f64> {
    ShVec::impulse(order, Direction::Z, 1.0)
}

fn scalar(file: FileCoefficients) -> ShVec<f64> {
    match file {
        FileCoefficients::Scalar(f) => f,
        FileCoefficients::Rgb(_) => panic!("numbers expected, found colors"),
    }
}

/// Radiance of a reddish sun on a blue sky, of which the red irradiance rings most.
fn sun() -> ShVec<Rgb<f64>> {
    let sun = ShVec::impulse(4, Direction::from_angles(1.0, 2.0), Rgb::new(5.0, 3.0, 1.0));
    &sun + &ShVec::constant(4, Rgb::new(0.05, 0.1, 0.2))
}

fn least_sampled(f: &ShVec<Rgb<f64>>) -> [f64; 3] {
    let values = fibonacci_sphere(4000).into_iter().map(|s| f.eval(Direction::from_unit(s)));
    values.fold([f64::INFINITY; 3], |m, v| [0, 1, 2].map(|c| v.channel(c).min(m[c])))
}

#[test]
fn windows_scale_the_bands_by_their_published_factors() {
    let dir = Dir::new();
    let f = impulse(6);
    dir.sh("p.sh.json", Quantity::Irradiance, f.clone());
    let sinc = |x: f64| x.sin() / x;
    type Factor = Box<dyn Fn(f64) -> f64>;
    let cases: [(&str, Factor); 7] = [
        ("--kind hanning", Box::new(|l| 0.5 * (1.0 + (PI * l / 6.0).cos()))),
        ("--kind lanczos --width 9.8725", Box::new(move |l| sinc(PI * l / 9.8725))),
        ("--kind sinc4 --width 12", Box::new(move |l| sinc(PI * l / 12.0).powi(4))),
        ("--kind lanczos --width 12 --power 2.5", Box::new(move |l| sinc(PI * l / 12.0).powf(2.5))),
        ("--kind gauss --width 18", Box::new(|l| (-0.5 * (PI / 10.0).powi(2) * l * (l + 1.0)).exp())),
        ("--kind laplacian --lambda 0.004209", Box::new(|l| 1.0 / (1.0 + 0.004209 * (l * (l + 1.0)).powi(2)))),
        ("--kind laplacian --lambda 0", Box::new(|_| 1.0)),
    ];
    for (options, factor) in cases {
        dir.lobe(&format!("sh window p.sh.json {options} -o q.sh.json")).stdout();
        let file = dir.read_sh("q.sh.json");
        assert_eq!(file.quantity, Quantity::Irradiance, "{options} keeps the quantity");
        let g = scalar(file.coefficients);
        for l in 0..6 {
            let i = l * (l + 1);
            let expected = f[i] * if l == 0 { 1.0 } else { factor(l as f64) };
            assert!((g[i] - expected).abs() < 1e-14, "{options}, band {l}: {} against {expected}", g[i]);
        }
    }
}

#[test]
fn by_content_the_sun_keeps_its_peak_and_the_far_half_its_window() {
    let dir = Dir::new();
    let f = sun().resized(6);
    dir.sh("p.sh.json", Quantity::Radiance, f.clone());
    let written = |options: &str| {
        let (_, note) = dir.lobe(&format!("sh window p.sh.json --kind hanning {options} -o q.sh.json")).succeeds();
        let file = dir.read_sh("q.sh.json");
        assert_eq!(file.quantity, Quantity::Radiance, "{options} keeps the quantity");
        (file.coefficients.to_rgb(), note)
    };
    let (plain, note) = written("");
    assert_eq!(note, "", "nothing to say about a window alone");
    let light = Direction::from_angles(1.0, 2.0);
    for (order, close) in [("24", 0.01), ("64", 0.001)] {
        let (blend, note) = written(&format!("--content --order {order}"));
        assert!(
            note.contains("as it is towards -0.35") && note.contains(&format!("order {order} leaves out 0.")),
            "{note}"
        );
        let [raw, kept] = [f.eval(light), blend.eval(light)].map(|c| c.r);
        assert!((kept / raw - 1.0).abs() < close, "order {order}: {kept} of {raw} towards the light");
        let [calm, far] = [plain.eval(-light), blend.eval(-light)].map(|c| c.r);
        assert!((far - calm).abs() < close * raw, "order {order}: {far} against {calm} away from the light");
    }
    let (same_order, note) = written("--content");
    assert_eq!(same_order.order(), 6, "the order of the input: {note}");
    assert!(least_sampled(&same_order)[0] > least_sampled(&f)[0], "it rings less");
    dir.sh("p.sh.json", Quantity::Radiance, ShVec::<f64>::constant(3, 2.0));
    let (flat, note) = written("--content");
    assert!(note.contains("band 1 has no direction; the window is applied everywhere"), "{note}");
    assert_eq!(flat.order(), 3, "a constant: {flat:?}");
    for (options, part) in [("--order 8", "--content"), ("--content --order 257", "from 1 to 256")] {
        let error = dir.lobe(&format!("sh window p.sh.json --kind hanning {options} -o r.sh.json")).error();
        assert!(error.contains(part), "{options}: {error}");
    }
    assert!(!dir.names().contains(&"r.sh.json".to_owned()), "nothing is written: {:?}", dir.names());
}

#[test]
fn keep_finds_the_published_lambdas_of_an_impulse() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, impulse(6));
    for (keep, lambda) in [("0.1", 0.00420855331055888), ("0.5", 0.000631543536668657)] {
        let (stdout, note) = dir.lobe(&format!("sh window p.sh.json --kind laplacian --keep {keep} -o -")).succeeds();
        let told = note.split_whitespace().skip_while(|word| *word != "--lambda").nth(1).unwrap_or_default();
        let told: f64 = told.parse().unwrap_or_else(|e| panic!("{note}: {e}"));
        assert!((told / lambda - 1.0).abs() < 1e-12, "{note}");
        dir.file("kept.sh.json", stdout);
        let (kept, f) = (scalar(dir.read_sh("kept.sh.json").coefficients), impulse(6));
        for l in 1..6 {
            let i = l * (l + 1);
            let found = (f[i] / kept[i] - 1.0) / (i * i) as f64;
            assert!((found / lambda - 1.0).abs() < 1e-9, "{keep}, band {l}: λ {found} against {lambda}");
        }
    }
}

#[test]
fn a_peak_finds_the_published_widths_of_an_impulse() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, impulse(6));
    for (options, width) in [
        ("--kind hanning", 12.010498388175),
        ("--kind lanczos", 9.872527032259),
        ("--kind lanczos --power 2", 13.712128048),
    ] {
        let (_, note) = dir.lobe(&format!("sh window p.sh.json {options} --peak 2.25 -o q.sh.json")).succeeds();
        let told = note.split_whitespace().skip_while(|word| *word != "--width").nth(1).unwrap_or_default();
        let told: f64 = told.parse().unwrap_or_else(|e| panic!("{note}: {e}"));
        assert!((told - width).abs() < 1e-9, "{options}: {note}");
        let peak = scalar(dir.read_sh("q.sh.json").coefficients).eval(Direction::Z);
        assert!((peak - 2.25).abs() < 1e-12, "{options}: {peak}");
    }
    let error = dir.lobe("sh window p.sh.json --kind lanczos --power 0.01 --peak 2.25 -o r.sh.json").error();
    assert!(error.contains("no width of this window has the peak 2.25; take a larger --power"), "{error}");
    for peak in ["0.05", "3"] {
        let error = dir.lobe(&format!("sh window p.sh.json --kind hanning --peak {peak} -o r.sh.json")).error();
        let expected = format!(
            "p.sh.json: --peak: expected a value between 0.079577 and 2.864789, the mean and the peak of an impulse of \
             order 6, found {peak}"
        );
        assert_eq!(error, expected, "a peak that no width gives");
    }
    assert_eq!(dir.names(), ["p.sh.json", "q.sh.json"], "nothing else is written");
}

#[test]
fn the_window_of_point_lights_says_what_it_drops() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, impulse(4));
    let (_, note) = dir.lobe("sh window p.sh.json --kind punctual -o q.sh.json").succeeds();
    assert!(note.contains("later bands become zero"), "{note}");
    let (f, g) = (impulse(4), scalar(dir.read_sh("q.sh.json").coefficients));
    for (i, factor) in [(0, 1.0), (2, 0.92), (6, 0.73), (12, 0.0)] {
        assert!((g[i] - factor * f[i]).abs() < 1e-15, "coefficient {i}: {} of {}", g[i], f[i]);
    }
    dir.sh("p.sh.json", Quantity::Radiance, impulse(3));
    dir.lobe("sh window p.sh.json --kind punctual -o q.sh.json").stdout();
}

#[test]
fn the_window_of_a_horizon_damps_what_is_symmetric_about_the_zenith_and_nothing_else() {
    let dir = Dir::new();
    let f = &sun() + &impulse(4).map(|c| Rgb::splat(0.3 * c));
    dir.sh("p.sh.json", Quantity::Radiance, f.clone());
    dir.lobe("sh window p.sh.json --kind horizon -o q.sh.json").stdout();
    let file = dir.read_sh("q.sh.json");
    assert_eq!(file.quantity, Quantity::Radiance, "the quantity stays");
    let FileCoefficients::Rgb(g) = file.coefficients else { panic!("colors stay colors") };
    for l in 0..4_usize {
        let x = PI * l as f64 / 4.0;
        for i in l * l..(l + 1).pow(2) {
            let factor = if l > 0 && i == l * (l + 1) { x.sin() / x } else { 1.0 };
            let off = (0..3).map(|c| (g[i].channel(c) - factor * f[i].channel(c)).abs()).fold(0.0, f64::max);
            assert!(off < 1e-14, "coefficient {i}: {:?} of {:?}", g[i], f[i]);
        }
    }
}

#[test]
fn options_of_windows_that_would_be_ignored_are_refused() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, impulse(3));
    for (options, part) in [
        ("--kind laplacian --keep 0.5 --width 4", "--width: only hanning, lanczos, sinc4 and gauss"),
        ("--kind punctual --width 4", "--width: only"),
        ("--kind hanning --lambda 1", "--lambda: only --kind laplacian"),
        ("--kind gauss --width 9 --keep 0.5", "--keep: only --kind laplacian"),
        ("--kind laplacian", "--lambda L, or"),
        ("--kind laplacian --keep 0.5 --lambda 1", "cannot be used with"),
        ("--kind gauss", "--width W"),
        ("--kind lanczos --width 0", "a number above 0"),
        ("--kind lanczos --width -3", "a number above 0"),
        ("--kind laplacian --lambda -1", "a weight of 0 or more, found -1"),
        ("--kind laplacian --keep 0", "a fraction above 0 and up to 1, found 0"),
        ("--kind laplacian --keep 1.5", "up to 1, found 1.5"),
        ("--kind box", "hanning"),
        ("--kind sinc4 --power 2", "--power: only --kind lanczos has one; choose it, or leave the power out"),
        ("--kind lanczos --power 0", "a number above 0"),
        ("--kind gauss --width 9 --peak 1", "cannot be used with"),
        ("--kind laplacian --keep 0.5 --peak 1", "--peak: only the width of hanning, lanczos and sinc4"),
        ("--kind horizon --width 4", "--width: only hanning, lanczos, sinc4 and gauss"),
        ("--kind horizon --peak 1", "--peak: only the width of hanning, lanczos and sinc4"),
        ("--kind horizon --content", "--content: horizon knows no light"),
    ] {
        let error = dir.lobe(&format!("sh window p.sh.json {options} -o q.sh.json")).error();
        assert!(error.contains(part), "{options}: {error}");
    }
    assert_eq!(dir.names(), ["p.sh.json"], "nothing is written");
}

#[test]
fn min_proves_the_least_value() {
    let dir = Dir::new();
    // 4π times the irradiance of an impulse of order 3, over π: least -0.158333 where z = -8/15.
    let e = impulse(3).convolved(&Zonal::clamped_cosine(3));
    dir.sh("e.sh.json", Quantity::Irradiance, e.map(|c| c * 4.0));
    let found = json(&dir, "sh min e.sh.json --json");
    let [channel] = &found["channels"].as_array().unwrap()[..] else { panic!("one channel expected: {found}") };
    let [min, lo, hi] = ["min", "lo", "hi"].map(|key| channel[key].as_f64().unwrap());
    let z = numbers(&channel["dir"])[2];
    assert!((min + 0.158_333_333).abs() < 1e-8 && (z + 8.0 / 15.0).abs() < 1e-6, "{found}");
    assert!(lo <= min && min <= hi && hi - lo < 1e-6, "{found}");

    dir.sh("sun.sh.json", Quantity::Radiance, sun());
    let sampled = least_sampled(&sun());
    for tolerance in ["1e-3", "1e-9"] {
        let found = json(&dir, &format!("sh min sun.sh.json --tolerance {tolerance} --json"));
        let channels = found["channels"].as_array().unwrap();
        assert_eq!(channels.len(), 3, "{found}");
        for (c, (channel, sampled)) in channels.iter().zip(sampled).enumerate() {
            let [lo, hi] = ["lo", "hi"].map(|key| channel[key].as_f64().unwrap());
            let width = 5.0 * tolerance.parse::<f64>().unwrap();
            assert!(lo <= sampled && hi - lo < width, "channel {c}: [{lo}, {hi}], sampled {sampled}");
        }
    }
    let text = dir.lobe("sh min sun.sh.json").stdout();
    assert!(text.starts_with("red -") && text.lines().count() == 3 && text.contains("\nblue "), "{text}");
    let error = dir.lobe("sh min sun.sh.json --tolerance 0").error();
    assert!(error.contains("above 0"), "{error}");
}

#[test]
fn the_closed_bound_is_below_the_least_value() {
    let dir = Dir::new();
    dir.sh("sun.sh.json", Quantity::Radiance, sun().resized(3));
    let [bounds, minima] = ["--bound ", ""].map(|bound| json(&dir, &format!("sh min sun.sh.json {bound}--json")));
    for c in 0..3 {
        let bound = bounds["channels"][c]["bound"].as_f64().unwrap();
        let min = minima["channels"][c]["min"].as_f64().unwrap();
        assert!(bound <= min && min - bound < 1e-6 * min.abs(), "channel {c} is zonal: {bounds}, {minima}");
    }
    let text = dir.lobe("sh min sun.sh.json --bound").stdout();
    assert!(text.starts_with("red -") && text.lines().count() == 3 && text.contains("\nblue "), "{text}");
    dir.sh("sun.sh.json", Quantity::Radiance, sun());
    let error = dir.lobe("sh min sun.sh.json --bound").error();
    assert!(error.contains("expected up to three bands, found order 4"), "{error}");
    let error = dir.lobe("sh min sun.sh.json --bound --tolerance 1e-3").error();
    assert!(error.contains("cannot be used with"), "{error}");
}

#[test]
fn peaks_are_all_maxima_and_the_highest_first() {
    let dir = Dir::new();
    let lights = [(Direction::X, 1.0), (Direction::Y, 3.0), (-Direction::Z, 2.0)];
    let zero = ShVec::<Rgb<f64>>::zero(10);
    let f = lights.iter().fold(zero, |f, (s, x)| &f + &ShVec::impulse(10, *s, Rgb::new(*x, *x, *x)));
    dir.sh("p.sh.json", Quantity::Radiance, f.clone());
    let found = json(&dir, "sh peaks p.sh.json --json");
    let peaks = found["peaks"].as_array().unwrap();
    for (peak, (expected, _)) in peaks.iter().zip([lights[1], lights[2], lights[0]]) {
        let s: [f64; 3] = numbers(&peak["dir"]).try_into().unwrap();
        let s = Direction::from_unit(s);
        let value = peak["value"].as_f64().unwrap();
        assert!(s.angle_to(expected) < 0.1, "{peak} for {expected:?}");
        assert!((value - f.eval(s).luminance()).abs() < 1e-12, "{peak}");
    }
    let values: Vec<f64> = peaks.iter().map(|p| p["value"].as_f64().unwrap()).collect();
    assert!(values.is_sorted_by(|a, b| a >= b), "the highest first: {values:?}");
    let text = dir.lobe("sh peaks p.sh.json --search paper").stdout();
    assert!(text.lines().count() == peaks.len() && text.contains(" towards "), "{text}");
    dir.sh("flat.sh.json", Quantity::Radiance, ShVec::<f64>::constant(3, 2.0));
    assert_eq!(dir.lobe("sh peaks flat.sh.json").stdout(), "no maximum: the same value everywhere\n", "a constant");
}

#[test]
fn dering_ends_all_negative_values_of_what_is_asked() {
    let dir = Dir::new();
    let sun = sun();
    let e = sun.convolved(&Zonal::clamped_cosine(4));
    dir.sh("l.sh.json", Quantity::Radiance, sun.clone());
    dir.sh("e.sh.json", Quantity::Irradiance, e.clone());
    let deringed = |args: &str| {
        let report = json(&dir, &format!("sh dering {args} -o q.sh.json --json"));
        (report, dir.read_sh("q.sh.json").coefficients.to_rgb())
    };
    let (of_light, light) = deringed("l.sh.json");
    let (of_irradiance, irradiance) = deringed("e.sh.json --quantity irradiance");
    let (of_light_for_irradiance, light_for_irradiance) = deringed("l.sh.json --quantity irradiance");
    let [a, b] = [&of_irradiance, &of_light_for_irradiance].map(|report| numbers(&report["bands"]));
    let is_same = a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(is_same, "the factors do not depend on what is stored: {a:?}, {b:?}");
    for (name, report, before, after) in [
        ("radiance", &of_light, &sun, &light),
        ("irradiance", &of_irradiance, &e, &irradiance),
        (
            "irradiance of radiance",
            &of_light_for_irradiance,
            &e,
            &light_for_irradiance.convolved(&Zonal::clamped_cosine(4)),
        ),
    ] {
        let [lows, now] = ["min_before", "min_after"].map(|key| numbers(&report[key]));
        let bands = numbers(&report["bands"]);
        for c in 0..3 {
            let mean = before.mean().channel(c);
            let (was, is) = (least_sampled(before)[c], least_sampled(after)[c]);
            assert!((lows[c] - was).abs() < 0.01 * mean && lows[c] <= was, "{name}, channel {c}: {was}, {report}");
            assert!(now[c] <= is && is >= -1e-6 * mean && now[c] >= -1e-6 * mean, "{name}, {c}: {is}, {report}");
        }
        assert!(lows[0] < 0.0, "{name} rings: {report}");
        assert!(bands[0] == 1.0 && bands.iter().all(|w| (0.0..=1.0).contains(w)), "{name}: {report}");
        let energy = |f: &ShVec<Rgb<f64>>| f.dot(f).to_array().iter().sum::<f64>();
        let removed = 1.0 - energy(after) / energy(before);
        assert!((report["energy_removed"].as_f64().unwrap() - removed).abs() < 1e-12, "{name}: {removed}, {report}");
    }
    assert!(least_sampled(&light_for_irradiance)[0] < 0.0, "radiance may ring as long as its irradiance does not");
}

#[test]
fn every_method_of_dering_works_and_what_is_not_negative_stays() {
    let dir = Dir::new();
    let e = sun().resized(3).convolved(&Zonal::clamped_cosine(3));
    dir.sh("e.sh.json", Quantity::Irradiance, e.clone());
    let mut removed = Vec::new();
    for method in ["least-change", "table", "hanning", "lanczos", "lanczos:2", "sinc4", "gauss", "laplacian"] {
        let report = json(&dir, &format!("sh dering e.sh.json --method {method} -o q.sh.json --json"));
        let least = numbers(&report["min_after"]);
        let is_gone = least.iter().enumerate().all(|(c, min)| *min > -1e-6 * e.mean().channel(c));
        assert!(is_gone, "{method}: {report}");
        removed.push(report["energy_removed"].as_f64().unwrap());
    }
    assert!(removed[1..].iter().all(|r| *r > removed[0]), "least-change changes least: {removed:?}");

    let (stdout, note) = dir.lobe("sh dering q.sh.json -o -").succeeds();
    assert!(note.contains("left as it is"), "{note}");
    assert_eq!(stdout.into_bytes(), dir.bytes("q.sh.json"), "unchanged");
    let (_, note) = dir.lobe("sh dering e.sh.json -o r.sh.json").succeeds();
    assert!(note.contains("least value -") && note.contains("% of the energy removed"), "{note}");
}

#[test]
fn what_cannot_be_made_non_negative_is_one_line() {
    let dir = Dir::new();
    let rgb = |r: f64, g: f64, b: f64| {
        let mut f = ShVec::impulse(3, Direction::X, Rgb::new(1.0, 1.0, 1.0));
        f[0] = Rgb::new(r, g, b);
        f
    };
    dir.sh("dark.sh.json", Quantity::Irradiance, rgb(1.0, -0.5, 1.0));
    dir.sh("none.sh.json", Quantity::Radiance, rgb(1.0, 1.0, 0.0).map(|c| c.b));
    dir.sh("log.sh.json", Quantity::LogVisibility, impulse(2));
    dir.sh("transfer.sh.json", Quantity::Transfer, impulse(2));
    dir.sh("e.sh.json", Quantity::Irradiance, impulse(5));
    dir.sh("radiance.sh.json", Quantity::Radiance, impulse(3));
    dir.sh("zero.sh.json", Quantity::Irradiance, ShVec::<f64>::zero(3));
    for (args, part) in [
        ("dark.sh.json", "the mean of green is -0.14"),
        ("none.sh.json", "the mean is 0.0; expected one above 0"),
        ("log.sh.json", "log-visibility is negative by its nature"),
        ("transfer.sh.json --quantity irradiance", "expected radiance or irradiance, found transfer"),
        ("e.sh.json --quantity radiance", "expected radiance, found irradiance"),
        ("e.sh.json --method table", "up to three bands, found order 5"),
        ("radiance.sh.json --method table", "found a function that rings more; choose least-change"),
        ("e.sh.json --method auto", "expected least-change"),
        ("e.sh.json --method lanczos:0", "lanczos:0"),
    ] {
        let error = dir.lobe(&format!("sh dering {args} -o q.sh.json")).error();
        assert!(error.contains(part), "{args}: {error}");
    }
    let error = dir.lobe("sh dering e.sh.json -o - --json").error();
    assert!(error.contains("both the expansion and the JSON"), "{error}");
    assert!(!dir.names().contains(&"q.sh.json".to_owned()), "nothing is written: {:?}", dir.names());
    let report = json(&dir, "sh dering zero.sh.json -o q.sh.json --json");
    assert_eq!(numbers(&report["min_after"]), [0.0], "zero stays zero: {report}");
}
