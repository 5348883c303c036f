//! `lobe sh log` and `lobe sh exp`.

use lobe::sh::expansion::Quantity;
use lobe::sh::exponential::{ExpMethod, Exponential, LOG_CLAMP, logarithm};
use lobe::sh::sh_json::{FileCoefficients, ShFile};
use lobe::sh::{Coefficient as _, Dir as Direction, Expansion as _, Rgb, ShVec, Zonal, project};
use serde_json::Value;

use crate::harness::Dir;

/// What a sphere of 20 degrees leaves visible.
fn visibility(towards: Direction) -> ShVec<f64> {
    &ShVec::constant(4, 1.0) + &Zonal::cone(4, 20.0_f64.to_radians()).towards(towards, -1.0)
}

fn numbers(file: ShFile) -> ShVec<f64> {
    let FileCoefficients::Scalar(f) = file.coefficients else { panic!("expected numbers: {:?}", file.coefficients) };
    f
}

#[test]
fn shadows_add_up_as_logarithms() {
    let dir = Dir::new();
    let (a, b) = (visibility(Direction::Z), visibility(Direction::X));
    dir.sh("a.sh.json", Quantity::Visibility, a.clone());
    dir.sh("b.sh.json", Quantity::Visibility, b.clone());
    dir.lobe("sh log a.sh.json -o la.sh.json").stdout();
    dir.lobe("sh log b.sh.json -o lb.sh.json").stdout();
    assert_eq!(dir.read_sh("la.sh.json").quantity, Quantity::LogVisibility, "of the logarithm");
    dir.lobe("sh add la.sh.json lb.sh.json -o sum.sh.json").stdout();
    let sum = &logarithm(&a, LOG_CLAMP) + &logarithm(&b, LOG_CLAMP);
    for (option, method) in [
        ("", ExpMethod::default()),
        ("--method grid", ExpMethod::Grid),
        ("--method optimal-linear", ExpMethod::OptimalLinear),
        ("--method hybrid", ExpMethod::Hybrid { limit: 1.0 }),
        ("--method series:4", ExpMethod::ProductSeries(4)),
        ("--method eigen", ExpMethod::Eigen),
    ] {
        dir.lobe(&format!("sh exp sum.sh.json -o both.sh.json {option}")).succeeds();
        let found = dir.read_sh("both.sh.json");
        assert_eq!(found.quantity, Quantity::Visibility, "{option}");
        let (found, expected) = (numbers(found), Exponential::new(4, method).of(&sum));
        let worst = found.coefficients().iter().zip(expected.coefficients()).map(|(a, b)| (a - b).abs());
        assert!(worst.clone().fold(0.0, f64::max) < 1e-12, "{option}: {:?}", worst.collect::<Vec<_>>());
    }
}

#[test]
fn the_bound_that_is_printed_holds() {
    let dir = Dir::new();
    let sphere = |towards| Zonal::sphere_logarithm(4, 8.0_f64.to_radians(), LOG_CLAMP).towards(towards, 1.0);
    let sum = &sphere(Direction::Z) + &sphere(Direction::X);
    let dim = &sum + &ShVec::constant(4, -0.5);
    let double = sum.map(|c| 2.0 * c);
    let channels = [&sum, &dim, &double];
    let mut rgb = sum.map(Rgb::splat);
    for (i, c) in rgb.coefficients_mut().iter_mut().enumerate() {
        *c = Rgb::from(channels.map(|f| f[i]));
    }
    dir.sh("q.sh.json", Quantity::LogVisibility, rgb);
    for (option, method) in [("grid", ExpMethod::Grid), ("series:2", ExpMethod::ProductSeries(2))] {
        let command = format!("sh exp q.sh.json -o p.sh.json --method {option}");
        let (_, note) = dir.lobe(&command).succeeds();
        let printed: Value = serde_json::from_str(&dir.lobe(&format!("{command} --json")).stdout()).unwrap();
        let bounds: Vec<f64> = printed["error_bound"].as_array().unwrap().iter().map(|b| b.as_f64().unwrap()).collect();
        assert_eq!(bounds.len(), 3, "{printed}");
        let said: f64 = note.trim_end().rsplit(' ').next().unwrap().parse().unwrap();
        let worst = bounds.iter().copied().fold(0.0, f64::max);
        assert!(said >= worst && said < 1.2 * worst, "{note}: {worst}");
        let FileCoefficients::Rgb(found) = dir.read_sh("p.sh.json").coefficients else { panic!("expected colors") };
        for (k, (f, bound)) in channels.iter().zip(bounds).enumerate() {
            let truth = match method {
                ExpMethod::Grid => project(4, 60, |s: Direction| f.eval(s).exp()),
                _ => Exponential::new(4, ExpMethod::Eigen).of(*f),
            };
            let rest = &found.map(|c| c.to_array()[k]) + &truth.map(|c| -c);
            let error = rest.dot(&rest).sqrt();
            assert!(error > 0.0 && error <= bound && bound < 0.5, "{option}, channel {k}: {error}, bound {bound}");
        }
    }
    let printed = dir.lobe("sh exp q.sh.json -o p.sh.json --method eigen --json").stdout();
    assert_eq!(printed, "{\"error_bound\":[null,null,null]}\n", "eigenvectors have none");
    assert_eq!(dir.lobe("sh exp q.sh.json -o p.sh.json --method hybrid").stdout(), "", "nor has the hybrid");
    let error = dir.lobe("sh exp q.sh.json -o - --json").error();
    assert!(error.starts_with("stdout: both the expansion and the JSON"), "{error}");
}

#[test]
fn colors_are_taken_channel_by_channel() {
    let dir = Dir::new();
    let f = visibility(Direction::Y);
    dir.sh("f.sh.json", Quantity::Visibility, f.map(Rgb::splat));
    dir.lobe("sh log f.sh.json -o l.sh.json --clamp 0.1").stdout();
    let FileCoefficients::Rgb(found) = dir.read_sh("l.sh.json").coefficients else { panic!("expected colors") };
    let expected = logarithm(&f, 0.1);
    for (found, expected) in found.coefficients().iter().zip(expected.coefficients()) {
        assert!((found.g - expected).abs() < 1e-12, "{found:?} against {expected}");
    }
}

#[test]
fn what_cannot_be_is_refused_in_one_line() {
    let dir = Dir::new();
    dir.sh("v.sh.json", Quantity::Visibility, visibility(Direction::Z));
    dir.sh("r.sh.json", Quantity::Radiance, visibility(Direction::Z));
    dir.sh("large.sh.json", Quantity::Visibility, ShVec::constant(11, 1.0));
    dir.sh("huge.sh.json", Quantity::LogVisibility, ShVec::constant(4, 1e6));
    for (command, said) in [
        (
            "sh log r.sh.json -o x.sh.json",
            "r.sh.json: expected visibility, found radiance; lobe sh exp makes it of log-visibility",
        ),
        (
            "sh exp v.sh.json -o x.sh.json",
            "v.sh.json: expected log-visibility, found visibility; lobe sh log makes it of visibility",
        ),
        ("sh log large.sh.json -o x.sh.json", "expected order 10 at most, found 11"),
        ("sh log v.sh.json --clamp 0 -o x.sh.json", "expected a part above 0 and up to 1, found 0"),
        (
            "sh exp v.sh.json --method best -o x.sh.json",
            "expected grid, optimal-linear, hybrid[:NORM], series:P or eigen",
        ),
        ("sh exp v.sh.json --method series:0 -o x.sh.json", "a number of terms"),
        ("sh exp huge.sh.json -o x.sh.json", "huge.sh.json: its exponential is not finite"),
        ("sh exp huge.sh.json --method hybrid:4.8 -o x.sh.json", "huge.sh.json: its exponential is not finite"),
    ] {
        let line = dir.lobe(command).error();
        assert!(line.contains(said), "{command}: {line}");
    }
}
