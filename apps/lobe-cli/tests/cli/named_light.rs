//! `lobe light` and `lobe sh lights`: projection of analytic lights, and extraction of lights.

use std::f64::consts::PI;

use lobe::sh::expansion::Quantity;
use lobe::sh::light::Normalization;
use lobe::sh::sh_json::FileCoefficients;
use lobe::sh::{Coefficient as _, Dir as Direction, Expansion as _, Light, Rgb, ShVec};
use lobe_testkit::Random;
use serde_json::Value;

use crate::harness::Dir;

fn light(dir: &Dir, args: &str) -> ShVec<Rgb<f64>> {
    assert_eq!(dir.lobe(&format!("light {args} -o light.sh.json")).stdout(), "", "nothing is printed");
    let file = dir.read_sh("light.sh.json");
    assert_eq!(file.quantity, Quantity::Radiance, "lights are radiance");
    match file.coefficients {
        FileCoefficients::Rgb(f) => f,
        FileCoefficients::Scalar(f) => panic!("{f:?} has no color"),
    }
}

fn lights(dir: &Dir, args: &str) -> Value {
    serde_json::from_str(&dir.lobe(&format!("sh lights {args} --json")).stdout()).unwrap()
}

fn near(found: &Value, expected: f64, tolerance: f64) -> bool {
    found.as_f64().is_some_and(|x| (x - expected).abs() <= tolerance)
}

#[test]
fn a_facing_white_surface_leaves_the_color_of_every_light() {
    let dir = Dir::new();
    for shape in [
        "directional --dir 0,0,2",
        "sphere --dir 0,0,1 --distance 3 --radius 1",
        "sphere --dir 0,0,1 --half-angle 20",
        "cone --dir 0,0,1 --half-angle 0.01",
        "soft-cone --dir 0,0,1 --half-angle 120",
        "ambient",
    ] {
        for order in [2, 3, 6] {
            light(&dir, &format!("{shape} --color 0.5,1,2 --order {order}"));
            dir.lobe("sh convolve light.sh.json --kernel cosine -o e.sh.json").succeeds();
            let values = dir.lobe("sh eval e.sh.json --dir 0,0,1").stdout();
            let values: Vec<f64> = values.split_whitespace().map(|x| x.parse::<f64>().unwrap() / PI).collect();
            for (value, expected) in values.iter().zip([0.5, 1.0, 2.0]) {
                assert!((value - expected).abs() < 1e-12, "{shape}, order {order}: {values:?}");
            }
        }
    }
}

#[test]
fn the_half_angle_of_a_light_may_be_called_its_angle() {
    let dir = Dir::new();
    for shape in ["cone", "soft-cone", "sphere"] {
        let [a, b] = ["--angle", "--half-angle"].map(|option| light(&dir, &format!("{shape} --dir 0,0,1 {option} 20")));
        assert_eq!(a, b, "{shape}");
    }
}

#[test]
fn without_normalization_shapes_have_radiance_one() {
    let dir = Dir::new();
    let hemisphere = "hemisphere --sky 1,1,1 --ground 0,0,0 --normalize none";
    for (args, mean) in [
        ("cone --dir 1,0,0 --half-angle 90 --normalize none", 0.5),
        ("cone --dir 1,0,0 --half-angle 180 --normalize none", 1.0),
        ("polygon --normalize none --vertices 1,0,0 0,1,0 0,0,1", 0.125),
        (hemisphere, 0.5),
        ("gradient --zenith 1,1,1 --horizon 0,0,0 --ground 1,1,1", 0.5),
    ] {
        // The vertices are one argument, which the harness would split at its blanks.
        let f = if args.starts_with("polygon") { octant(&dir) } else { light(&dir, args) };
        assert!((f.mean().r - mean).abs() < 1e-14, "{args}: {:?}", f.mean());
    }
    let cut = dir.lobe("light polygon --horizon 0,0,-1 --normalize none -o light.sh.json --vertices");
    cut.arg("1,0,1 0,1,1 -1,-1,1").stdout();
    let FileCoefficients::Rgb(f) = dir.read_sh("light.sh.json").coefficients else { panic!("a light has a color") };
    assert_eq!(f, ShVec::zero(3), "nothing of it is below");
}

fn octant(dir: &Dir) -> ShVec<Rgb<f64>> {
    dir.lobe("light polygon --normalize none -o light.sh.json --vertices").arg("1,0,0 0,1,0 0,0,1").stdout();
    match dir.read_sh("light.sh.json").coefficients {
        FileCoefficients::Rgb(f) => f,
        FileCoefficients::Scalar(f) => panic!("{f:?} has no color"),
    }
}

#[test]
fn a_light_is_found_where_it_was_put() {
    let dir = Dir::new();
    light(&dir, "directional --dir 0,-1,0 --color 3,2,1 --order 4");
    for options in ["", "--count 3", "--count 2 --refine", "--metric radiance", "--choose height", "--closed"] {
        let found = lights(&dir, &format!("light.sh.json {options}"));
        assert!(near(&found["lights"][0]["dir"][1], -1.0, 1e-9), "{options}: {found}");
        for (channel, color) in [3.0, 2.0, 1.0].into_iter().enumerate() {
            assert!(near(&found["lights"][0]["intensity"][channel], color, 1e-6), "{options}: {found}");
            assert!(near(&found["ambient"][channel], 0.0, 1e-6), "{options}: {found}");
            assert!(near(&found["residual"][channel], 0.0, 1e-9), "{options}: {found}");
        }
    }
    dir.lobe("light directional --dir 0,0,1 --normalize none -o one.sh.json").stdout();
    let found = lights(&dir, "one.sh.json");
    let irradiance = found["lights"][0]["irradiance"][0].as_f64().unwrap();
    assert!((irradiance - 1.0).abs() < 1e-9, "a light of irradiance 1 comes out with it: {found}");
    let text = dir.lobe("sh lights light.sh.json").stdout();
    assert!(text.starts_with("light from ") && text.contains("intensity 3.000000 2.000000 1.000000"), "{text}");
    light(&dir, "ambient --color 1,2,3");
    let found = lights(&dir, "light.sh.json --count 5");
    assert!(found["lights"].as_array().unwrap().is_empty() && near(&found["ambient"][2], 3.0, 1e-12), "{found}");
}

#[test]
fn channels_may_have_lights_of_their_own() {
    let dir = Dir::new();
    let places = [Direction::X, Direction::Y, -Direction::Z];
    let mut f = ShVec::constant(3, Rgb::new(0.5, 0.5, 0.5));
    for (c, place) in places.into_iter().enumerate() {
        let color = Rgb::from_channels(|k| if k == c { 1.0 + c as f64 } else { 0.0 });
        let light = Light::Directional { dir: place, color };
        f += &light.project(3, Normalization::Projected).unwrap();
    }
    dir.sh("p.sh.json", Quantity::Radiance, f);
    for options in ["--closed", "", "--count 3 --refine"] {
        let found = lights(&dir, &format!("p.sh.json --per-channel {options}"));
        for (c, place) in places.into_iter().enumerate() {
            let channel = &found["channels"][c];
            let light = &channel["lights"][0];
            let is_there = (0..3).all(|k| near(&light["dir"][k], place.to_array()[k], 1e-7));
            assert!(is_there && near(&light["intensity"][0], 1.0 + c as f64, 1e-7), "{options}, channel {c}: {found}");
            assert!(near(&channel["ambient"][0], 0.5, 1e-7), "{options}, channel {c}: {found}");
        }
    }
    let text = dir.lobe("sh lights p.sh.json --per-channel --closed").stdout();
    assert!(text.starts_with("red: light from 1.000000 ") && text.contains("\nblue: ambient 0.500000\n"), "{text}");
    let error = dir.lobe("sh lights p.sh.json --closed --refine").error();
    assert!(error.contains("cannot be used with"), "{error}");
}

#[test]
fn lights_in_known_directions_get_their_intensities_in_the_order_given() {
    let dir = Dir::new();
    let mut f = ShVec::constant(4, Rgb::new(0.25, 0.5, 0.75));
    // Neither is a maximum of its own: they are 40° apart.
    let places = [Direction::from_angles(0.6, 0.0), Direction::from_angles(1.3, 0.0)];
    for (place, color) in places.into_iter().zip([Rgb::new(1.0, 2.0, 3.0), Rgb::new(2.0, 1.0, 0.5)]) {
        f += &Light::Directional { dir: place, color }.project(4, Normalization::Projected).unwrap();
    }
    dir.sh("p.sh.json", Quantity::Radiance, f);
    let option = |place: Direction| {
        let [x, y, z] = place.to_array();
        format!("--direction {x:?},{y:?},{z:?}")
    };
    // The lamp below is dark; it is kept.
    let options = format!("{} --direction 0,0,-7 {}", option(places[1]), option(places[0]));
    for metric in ["", "--metric radiance"] {
        let found = lights(&dir, &format!("p.sh.json {options} {metric}"));
        let expected = [(places[1], [2.0, 1.0, 0.5]), (-Direction::Z, [0.0; 3]), (places[0], [1.0, 2.0, 3.0])];
        assert_eq!(found["lights"].as_array().unwrap().len(), 3, "{metric}: {found}");
        for (k, (place, color)) in expected.into_iter().enumerate() {
            let light = &found["lights"][k];
            for c in 0..3 {
                assert!(near(&light["dir"][c], place.to_array()[c], 1e-12), "{metric}, light {k}: {light}");
                assert!(near(&light["intensity"][c], color[c], 1e-9), "{metric}, light {k}: {light}");
            }
        }
        for (c, ambient) in [0.25, 0.5, 0.75].into_iter().enumerate() {
            assert!(near(&found["ambient"][c], ambient, 1e-9), "{metric}: {found}");
            assert!(near(&found["residual"][c], 0.0, 1e-12), "{metric}: {found}");
        }
    }
    let text = dir.lobe(&format!("sh lights p.sh.json {options}")).stdout();
    assert_eq!(text.lines().filter(|line| line.starts_with("light from ")).count(), 3, "{text}");
    for (options, part) in [
        ("--direction 0,0,0", "points nowhere; give a vector that is not zero"),
        ("--direction 0,1", "expected 3 numbers with commas between them"),
        ("--direction 0,0,1 --count 2", "cannot be used with"),
        ("--direction 0,0,1 --refine", "cannot be used with"),
        ("--direction 0,0,1 --closed", "cannot be used with"),
        ("--direction 0,0,1 --per-channel", "cannot be used with"),
    ] {
        let error = dir.lobe(&format!("sh lights p.sh.json {options}")).error();
        assert!(error.contains(part), "{options}: {error}");
    }
    let many = "--direction 0,0,1 ".repeat(101);
    let error = dir.lobe(&format!("sh lights p.sh.json {many}")).error();
    assert_eq!(error, "--direction: expected 100 lights at most, found 101; leave some out", "101 lights");
}

#[test]
fn the_choice_of_lights_changes_which_maxima_are_taken() {
    let dir = Dir::new();
    let mut residuals = [0.0; 2];
    for seed in 0..12 {
        let f = ShVec::from_vec(Random::new(seed).signed_vec(36)).unwrap();
        dir.sh("p.sh.json", Quantity::Radiance, f);
        let [height, residual] =
            ["height", "residual"].map(|choose| lights(&dir, &format!("p.sh.json --count 3 --choose {choose}")));
        for (sum, found) in residuals.iter_mut().zip([&height, &residual]) {
            *sum += found["residual"][0].as_f64().unwrap();
        }
    }
    let [height, residual] = residuals;
    assert!(residual < height, "the lights that explain most leave {residual}, the highest maxima {height}");
}

#[test]
fn lights_that_cannot_be_are_refused() {
    let dir = Dir::new();
    for (args, part) in [
        (
            "light cone --dir 1,0,0 --half-angle 0 -o x.sh.json",
            "half angle lies above 0 and up to 180 degrees, found 0",
        ),
        ("light soft-cone --dir 1,0,0 --half-angle 181 -o x.sh.json", "found 181"),
        ("light sphere --dir 1,0,0 --half-angle 91 -o x.sh.json", "90 degrees at most"),
        (
            "light sphere --dir 1,0,0 --half-angle 30 --radius 1 -o x.sh.json",
            "--radius: only with --distance; --half-angle says by itself how large the ball looks",
        ),
        ("light sphere --dir 1,0,0 --distance 1 --radius 2 -o x.sh.json", "0 < radius < distance"),
        ("light polygon --vertices 1,0,0 -o x.sh.json", "three vertices at least, found 1"),
    ] {
        let error = dir.lobe(args).error();
        assert!(error.contains(part), "{args}: {error}");
    }
    let error = dir.lobe("light polygon -o x.sh.json --vertices").arg("1,0,0 -1,0,0 0,0,1").error();
    assert!(error.contains("edge 0 of the polygon passes through the receiver"), "{error}");
    let error = dir.lobe("light polygon -o x.sh.json --vertices").arg("1,0,0 2,0,0 3,0,0").error();
    assert!(error.contains("too little to be normalized"), "{error}");
    assert!(dir.names().is_empty(), "{:?}", dir.names());
    dir.sh("flat.sh.json", Quantity::Radiance, ShVec::constant(1, 1.0));
    let error = dir.lobe("sh lights flat.sh.json").error();
    assert!(error.starts_with("flat.sh.json: ") && error.contains("from order 2 on"), "{error}");
    dir.sh("e.sh.json", Quantity::Irradiance, ShVec::constant(3, 1.0));
    let error = dir.lobe("sh lights e.sh.json").error();
    assert_eq!(error, "e.sh.json: lights are found in radiance, this is irradiance", "irradiance");
}
