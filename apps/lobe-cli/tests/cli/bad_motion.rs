//! Bad input of the commands for what moves: each is one line, and nothing is written.

use lobe::sh::ShVec;
use lobe::sh::expansion::Quantity;
use lobe::shadow::{
    FieldStorage, Lamp, RadianceField, RadianceOptions, Rectangle, SphereSet, write_lamp, write_spheres,
};

use crate::harness::Dir;

const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n";
const RENDER: &str = "--env bundled:sunset --size 8x6 --bake-samples 4 --no-split --order 2 --quiet -o x.png";

/// A folder with a tetrahedron, and a description that has this member beside it.
fn scene(member: &str) -> Dir {
    let dir = Dir::new();
    dir.file("t.obj", TETRAHEDRON);
    dir.file("s.json", format!(r#"{{"format":"lobe-scene","version":1,"still":"t.obj"{member}}}"#));
    dir
}

/// Runs a command that must be refused, and leaves the folder as it was; its line.
fn refused(dir: &Dir, command: &str) -> String {
    let before = dir.names();
    let line = dir.lobe(command).error();
    assert_eq!(dir.names(), before, "files after lobe {command}");
    assert!(!line.contains("a fault of this program"), "lobe {command}: {line}");
    line
}

#[test]
fn numbers_out_of_range_are_refused_before_any_work() {
    let dir = scene("");
    for (command, expected) in [
        ("spheres t.obj -n 0 -o s.safetensors", "expected a number of spheres from 1"),
        ("spheres t.obj -n -3 -o s.safetensors", "a number of spheres"),
        ("spheres t.obj -n many -o s.safetensors", "a number of spheres"),
        ("spheres t.obj -n 4 --points 0 -o s.safetensors", "a number of points"),
        ("spheres table --order 9 -o s.safetensors", "an order (number of bands)"),
        ("field t.obj --order 9 -o f.safetensors", "from 1 to 8"),
        ("field t.obj --order 0 -o f.safetensors", "from 1 to 8"),
        ("field t.obj --rays 0 -o f.safetensors", "rays"),
        ("field t.obj -o f.obj", "f.obj"),
        ("lamp sphere --radius -1 -o l.safetensors", "-1"),
        ("lamp sphere --radius 0 -o l.safetensors", "found 0"),
        ("lamp sphere --radius nan -o l.safetensors", "nan"),
        ("lamp sphere --radius 1 --order 9 -o l.safetensors", "from 1 to 8"),
        ("lamp sphere --radius 1 --radiance 1,-1,1 -o l.safetensors", "negative"),
        ("lamp rectangle --size 1,nan -o l.safetensors", "nan"),
    ] {
        let line = refused(&dir, command);
        assert!(line.contains(expected), "lobe {command}: expected {expected:?} in: {line}");
    }
    for (options, expected) in [
        ("moving --time nan", "nan"),
        ("moving --time inf", "inf"),
        ("moving --fps 0 --frames 0..1", "found 0"),
        ("moving --fps 1e-300 --frames 0..1", "--fps: an animated .png shows each picture for 0.001 to 65 seconds"),
        ("moving --fps 1001 --frames 0..1", "found 1001.0 pictures for each second"),
        ("moving --fps 1e-310 --frames 0..1", "expected 1e-300 pictures for each second at least, found 1e-310"),
        ("moving --method exponentials --spheres 0", "a number of spheres"),
        ("moving --method exponentials --sphere-window -1", "-1"),
    ] {
        let line = refused(&dir, &format!("render {options} s.json {RENDER}"));
        assert!(line.contains(expected), "{options}: expected {expected:?} in: {line}");
    }
}

#[test]
fn files_of_another_kind_are_refused_by_name() {
    let dir = scene("");
    dir.file("text.safetensors", "no tensors");
    write_spheres(dir.path("spheres.safetensors"), &SphereSet::new(vec![[0.0; 3]], vec![1.0]).unwrap()).unwrap();
    for table in ["text", "spheres"] {
        let options = format!("moving --method exponentials --sphere-table {table}.safetensors");
        let line = refused(&dir, &format!("render {options} s.json {RENDER}"));
        assert!(line.starts_with(&format!("{table}.safetensors: ")), "{line}");
    }
    dir.file("broken.sh.json", "{\"format\":");
    dir.sh("radiance.sh.json", Quantity::Radiance, ShVec::constant(2, 1.0));
    for (command, name) in [("log", "broken"), ("exp", "broken"), ("log", "radiance"), ("exp", "radiance")] {
        let line = refused(&dir, &format!("sh {command} {name}.sh.json -o x.sh.json"));
        assert!(line.starts_with(&format!("{name}.sh.json: ")), "{line}");
    }
    let line = refused(&dir, "sh log none.sh.json -o x.sh.json");
    assert!(line.starts_with("none.sh.json: "), "{line}");
}

#[test]
fn lamps_of_descriptions_at_fault_are_refused_by_name() {
    for (lamps, expected) in [
        ("5", "lamps"),
        (r#"[{"radius":1}]"#, "missing field `name`"),
        (r#"[{"name":"a"}]"#, "lamp `a`: expected one of `file`, `radius` and `size`"),
        (r#"[{"name":"a","radius":NaN}]"#, "expected a description"),
        (r#"[{"name":"a","radius":-1}]"#, "lamp `a`: expected a radius"),
        (r#"[{"name":"a","radius":1,"radiance":[1,2]}]"#, "lamps[0].radiance"),
        (r#"[{"name":"a","radius":1,"keys":[{"time":1},{"time":0}]}]"#, "lamp `a`: expected times that rise"),
        (r#"[{"name":"a","file":"none.safetensors"}]"#, "none.safetensors"),
        (r#"[{"name":"a","file":"t.obj"}]"#, "t.obj"),
    ] {
        let dir = scene(&format!(r#","lamps":{lamps}"#));
        for method in ["moving", "trace --samples 2"] {
            let line = refused(
                &dir,
                &format!("render {method} s.json {}", RENDER.replace("--bake-samples 4 --no-split ", "")),
            );
            assert!(line.contains(expected), "{lamps}: expected {expected:?} in: {line}");
        }
    }
}

#[test]
fn a_lamp_of_a_file_has_its_order() {
    let dir = scene(r#","lamps":[{"name":"panel","file":"l.safetensors","keys":[{"translation":[0,0,3]}]}]"#);
    let options = RadianceOptions::default().order(2).spheres(4).cells(4);
    let light = lobe::sh::Rgb::new(1.0, 1.0, 1.0);
    let field = RadianceField::rectangle(&Rectangle::upright([1.0, 1.0], true), light, &options).unwrap();
    write_lamp(dir.path("l.safetensors"), &Lamp::Still(field), &FieldStorage::F32).unwrap();
    let line = refused(&dir, "render moving s.json --env bundled:sunset --size 8x6 --order 3 --quiet -o x.png");
    assert!(line.contains("lamp `panel`: expected light of 3 bands at least, found 2"), "{line}");
    dir.lobe(&format!("render moving s.json {RENDER}")).stdout();
    assert!(dir.names().contains(&"x.png".to_owned()), "{:?}", dir.names());
}

#[test]
fn the_truth_of_a_lamp_is_the_same_by_its_file_and_by_its_numbers() {
    let truth = |source: &str, make: &str| {
        let lamp = format!(r#"{{"name":"panel",{source},"keys":[{{"translation":[0,0,3]}}]}}"#);
        let dir = scene(&format!(r#","lamps":[{lamp}]"#));
        if !make.is_empty() {
            dir.lobe(&format!("lamp {make} --order 2 -o l.safetensors")).succeeds();
        }
        dir.lobe("render trace s.json --env bundled:sunset --size 8x6 --samples 4 --quiet -o x.exr").stdout();
        std::fs::read(dir.path("x.exr")).unwrap()
    };
    let panel = truth(r#""size":[2,1],"radiance":[40,20,10],"two_sided":true"#, "");
    let made = "rectangle --size 2,1 --radiance 40,20,10 --two-sided --spheres 2 --cells 2";
    assert!(truth(r#""file":"l.safetensors""#, made) == panel, "a rectangle");
    let ball = truth(r#""radius":0.5,"radiance":[40,20,10]"#, "");
    assert!(truth(r#""file":"l.safetensors""#, "sphere --radius 0.5 --radiance 40,20,10") == ball, "a ball");
    assert!(panel != ball, "each lights the picture its own way");
}

#[test]
fn lamps_light_pictures_of_every_mode_that_moves() {
    let lamp = r#"{"name":"bulb","radius":0.3,"radiance":[80,80,80],"keys":[{"translation":[1,1,3]}]}"#;
    let (with, without) = (scene(&format!(r#","lamps":[{lamp}]"#)), scene(""));
    for mode in [
        "moving --no-split --bake-samples 64",
        "moving --no-split --method exponentials --spheres 2 --bake-samples 64",
        "trace --samples 16",
    ] {
        let mean = |dir: &Dir| {
            let command = format!(
                "render {mode} s.json --env bundled:sunset --order 2 --size 16x12 --bounces 0 --quiet -o m.exr"
            );
            dir.lobe(&command).stdout();
            let (picture, _) = lobe::image::read_picture(dir.path("m.exr"), &Default::default()).unwrap();
            picture.pixels().iter().flatten().map(|c| f64::from(*c)).sum::<f64>() / picture.pixels().len() as f64
        };
        let (with, without) = (mean(&with), mean(&without));
        println!("{mode}: {with:.4} with the lamp, {without:.4} without");
        assert!(with > without + 0.05, "{mode}: {with} with the lamp, {without} without");
    }
}
