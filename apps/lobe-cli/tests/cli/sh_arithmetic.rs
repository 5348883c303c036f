//! `lobe sh add`, `scale` and `mirror`, alone and in chains.

use lobe::sh::expansion::Quantity;
use lobe::sh::rotation::{Axis, mirror_in_place};
use lobe::sh::sh_json::{FileCoefficients, ShFile};
use lobe::sh::{Coefficient as _, Dir as Direction, Expansion as _, Rgb, ShVec};

use crate::harness::Dir;

/// An expansion of numbers that are all different.
fn numbers(order: usize, first: f64) -> ShVec<f64> {
    ShVec::from_vec((0..order * order).map(|i| first + i as f64).collect()).unwrap()
}

#[test]
fn a_sum_has_the_highest_order_and_is_of_colors_if_one_term_is() {
    let dir = Dir::new();
    let (a, b) = (numbers(2, 1.0), numbers(3, 0.5));
    let c = numbers(1, 2.0).map(|x| Rgb::new(x, 0.0, -x));
    dir.sh("a.sh.json", Quantity::Radiance, a.clone());
    dir.sh("b.sh.json", Quantity::Radiance, b.clone());
    dir.sh("c.sh.json", Quantity::Radiance, c.clone());
    dir.lobe("sh add a.sh.json b.sh.json -o sum.sh.json").stdout();
    let expected = &a.resized(3) + &b;
    assert_eq!(dir.read_sh("sum.sh.json"), ShFile::new(Quantity::Radiance, expected.clone()), "numbers");
    dir.lobe("sh add a.sh.json b.sh.json c.sh.json --order 2 -o sum.sh.json").stdout();
    let expected = &expected.resized(2).map(Rgb::splat) + &c.resized(2);
    assert_eq!(dir.read_sh("sum.sh.json"), ShFile::new(Quantity::Radiance, expected), "colors, of order 2");
}

#[test]
fn what_does_not_add_up_is_refused_unless_the_sum_is_named() {
    let dir = Dir::new();
    dir.sh("r.sh.json", Quantity::Radiance, numbers(2, 1.0));
    dir.sh("e.sh.json", Quantity::Irradiance, numbers(2, 1.0));
    let line = dir.lobe("sh add r.sh.json e.sh.json -o s.sh.json").error();
    let said = "e.sh.json: irradiance is not added to radiance; --quantity names the result whatever it is";
    assert_eq!(line, said, "two quantities");
    dir.lobe("sh add r.sh.json e.sh.json --quantity radiance -o s.sh.json").stdout();
    assert_eq!(dir.read_sh("s.sh.json").quantity, Quantity::Radiance, "named");
    assert!(dir.lobe("sh add - - -o s.sh.json").error().contains("two inputs are -"), "stdin twice");
    assert!(dir.lobe("sh add r.sh.json -o s.sh.json").error().contains("2 values required"), "one term");
}

#[test]
fn factors_are_numbers_or_colors() {
    let dir = Dir::new();
    let f = numbers(2, 1.0);
    dir.sh("f.sh.json", Quantity::Transfer, f.clone());
    for (by, expected) in [
        ("-2", FileCoefficients::from(f.map(|x| -2.0 * x))),
        ("0.5,0.5,0.5", f.map(|x| 0.5 * x).into()),
        ("1,0,-1", f.map(|x| Rgb::new(x, 0.0 * x, -x)).into()),
    ] {
        dir.lobe(&format!("sh scale f.sh.json --by {by} -o s.sh.json")).stdout();
        assert_eq!(dir.read_sh("s.sh.json"), ShFile::new(Quantity::Transfer, expected), "by {by}");
    }
    assert!(dir.lobe("sh scale f.sh.json --by 1,2 -o s.sh.json").error().contains("expected 3 numbers"), "two");
}

#[test]
fn expansions_are_cut_off_or_filled_up_to_an_order() {
    let dir = Dir::new();
    let f = numbers(3, 1.0);
    dir.sh("f.sh.json", Quantity::Radiance, f.clone());
    for order in [1, 2, 3, 5] {
        dir.lobe(&format!("sh scale f.sh.json --order {order} --quantity visibility -o s.sh.json")).stdout();
        assert_eq!(dir.read_sh("s.sh.json"), ShFile::new(Quantity::Visibility, f.resized(order)), "order {order}");
    }
}

#[test]
fn a_mirror_exchanges_the_ends_of_its_axis() {
    let dir = Dir::new();
    let f = numbers(4, 1.0);
    dir.sh("f.sh.json", Quantity::Visibility, f.clone());
    let s = Direction::new([0.3, -0.5, 0.7]).unwrap();
    let [x, y, z] = s.to_array();
    for (name, axis, mirrored) in [("x", Axis::X, [-x, y, z]), ("y", Axis::Y, [x, -y, z]), ("z", Axis::Z, [x, y, -z])] {
        dir.lobe(&format!("sh mirror f.sh.json --axis {name} -o g.sh.json")).stdout();
        let mut expected = f.clone();
        mirror_in_place(expected.coefficients_mut(), axis);
        assert_eq!(dir.read_sh("g.sh.json"), ShFile::new(Quantity::Visibility, expected.clone()), "{name}");
        let (found, there) = (expected.eval(s), f.eval(Direction::new(mirrored).unwrap()));
        assert!((found - there).abs() < 1e-12, "{name}: {found} towards {s:?}, {there} at the mirrored place");
    }
}

#[test]
fn a_chain_gives_what_its_steps_give() {
    let dir = Dir::new();
    let f = numbers(3, 1.0);
    dir.sh("f.sh.json", Quantity::Radiance, f.clone());
    let mut text = String::from_utf8(dir.bytes("f.sh.json")).unwrap();
    for step in [
        "scale - --by 2",
        "mirror - --axis x",
        "window - --kind gauss --width 20",
        "add - f.sh.json",
        "window - --kind lanczos",
    ] {
        text = dir.lobe(&format!("sh {step} -o -")).stdin(text).stdout();
    }
    dir.file("end.sh.json", &text);
    let FileCoefficients::Scalar(found) = dir.read_sh("end.sh.json").coefficients else { panic!("numbers: {text}") };
    // Lanczos leaves the mean as it is, and so do all the others: 1, twice 1.
    assert!((found[0] - 3.0).abs() < 1e-12, "{found:?}");
}

#[test]
fn a_sky_without_its_sun_and_the_sun_make_the_sky() {
    let dir = Dir::new();
    dir.lobe("env sun bundled:sunset -o rest.exr --light sun.sh.json --order 4").succeeds();
    dir.lobe("project rest.exr --order 4 -o rest.sh.json").succeeds();
    dir.lobe("sh add rest.sh.json sun.sh.json -o both.sh.json").stdout();
    dir.lobe("project bundled:sunset --order 4 -o whole.sh.json").succeeds();
    let [both, whole, rest] =
        ["both", "whole", "rest"].map(|name| dir.read_sh(&format!("{name}.sh.json")).coefficients.to_rgb());
    let distance = |f: &ShVec<Rgb<f64>>| {
        let differences = f.coefficients().iter().zip(whole.coefficients());
        differences.map(|(a, b)| (0..3).map(|c| (a.channel(c) - b.channel(c)).powi(2)).sum::<f64>()).sum::<f64>().sqrt()
    };
    // The sun of the picture is no disc.
    let (with, without) = (distance(&both), distance(&rest));
    assert!(with < 0.01 * without, "{with} with the sun, {without} without it");
}
