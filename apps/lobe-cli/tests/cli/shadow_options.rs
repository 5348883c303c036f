//! Options of shadows in moving scenes, by which something is left out, cut off or compressed: each changes the result in the direction that it states.

use serde_json::Value;

use crate::harness::{Dir, mean};

const RENDER: &str = "--env bundled:sunset --size 32x24 --bake-samples 4 --no-split --order 3 --quiet";

/// Two tetrahedra over a terrain, which hide the sky by spheres (spheres.json) and by fields (field.json).
fn scenes() -> Dir {
    let dir = Dir::new();
    dir.file("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n");
    dir.lobe("spheres t.obj -n 12 --points 600 -o t.spheres.safetensors").succeeds();
    dir.lobe("field t.obj --order 3 --spheres 4 --cells 4 --rays 64 -o t.field.safetensors").succeeds();
    for kind in ["spheres", "field"] {
        let entity = |name: &str, key: &str| {
            format!(r#"{{"name":"{name}","mesh":"t.obj","{kind}":"t.{kind}.safetensors","keys":[{{{key}}}]}}"#)
        };
        let entities =
            [entity("a", r#""translation":[-1,-1,1],"scale":4"#), entity("b", r#""translation":[2,1,2],"scale":2"#)];
        let entities = entities.join(",");
        dir.file(
            &format!("{kind}.json"),
            format!(r#"{{"format":"lobe-scene","version":1,"still":"built-in:terrain","entities":[{entities}]}}"#),
        );
    }
    dir
}

/// The picture with these options.
fn picture(dir: &Dir, options: &str) -> Vec<f32> {
    dir.lobe(&format!("render moving {RENDER} {options} -o p.exr")).succeeds();
    dir.numbers("p.exr")
}

/// The root mean square difference of two pictures.
fn off(a: &[f32], b: &[f32]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

/// The differences of pictures from one, which rise with the value of an option.
fn rises(dir: &Dir, exact: &[f32], option: &str, values: &[&str]) {
    let found: Vec<f64> = values.iter().map(|value| off(&picture(dir, &format!("{option} {value}")), exact)).collect();
    println!("{option} {values:?}: {found:?}");
    assert!(found.windows(2).all(|pair| pair[0] <= pair[1]), "{option} {values:?}: {found:?}");
    assert!(found[0] < 0.5 * found[found.len() - 1], "{option} {values:?} changes the picture: {found:?}");
}

#[test]
fn spheres_are_nearer_to_each_by_itself_the_less_is_cut() {
    let dir = scenes();
    let spheres = "spheres.json --method exponentials";
    let exact = picture(&dir, &format!("{spheres} --cut 0"));
    rises(&dir, &exact, &format!("{spheres} --cut"), &["0.1", "0.3", "1"]);
    let grouped = format!("{spheres} --cut 0 --group 64 --far");
    rises(&dir, &exact, &grouped, &["0", "0.1", "1"]);
    let unshared = picture(&dir, &format!("{spheres} --cut 0 --no-share-overlaps"));
    assert!(mean(&unshared) < mean(&exact), "what overlaps hides twice: {} and {}", mean(&unshared), mean(&exact));
}

#[test]
fn fields_are_nearer_to_all_of_them_the_less_is_negligible() {
    let dir = scenes();
    let exact = picture(&dir, "field.json --negligible 0");
    rises(&dir, &exact, "field.json --negligible", &["0.001", "0.1", "12.5"]);
}

#[test]
fn tables_have_fewer_rows_the_larger_their_tolerance_and_are_as_near_to_the_finest() {
    let dir = scenes();
    let table = |tolerance: &str| {
        let command = format!("spheres table -o t{tolerance}.safetensors --order 3 --tolerance {tolerance}");
        let (printed, _) = dir.lobe(&command).succeeds();
        let rows: usize = printed.lines().last().unwrap().rsplit(' ').next().unwrap().parse().unwrap();
        (rows, picture(&dir, &format!("spheres.json --method exponentials --sphere-table t{tolerance}.safetensors")))
    };
    let [(finest, exact), (fine, near), (coarse, far)] = ["0.001", "0.01", "0.5"].map(table);
    assert!(finest > fine && fine > coarse, "rows: {finest}, {fine}, {coarse}");
    for (tolerance, found) in [(0.01, near), (0.5, far)] {
        // A tolerance is a part of what a sphere hides, which is a part of all.
        assert!(off(&found, &exact) < tolerance * mean(&exact), "{tolerance}: {}", off(&found, &exact));
    }
}

#[test]
fn a_field_takes_more_bytes_and_is_nearer_with_more_clusters_and_components() {
    let dir = Dir::new();
    let field = "field built-in:ball -o f.safetensors --order 3 --spheres 4 --cells 8 --rays 16 --json --quiet";
    let storage = |options: &str| {
        let (printed, _) = dir.lobe(&format!("{field} --storage clustered {options}")).succeeds();
        let storage = serde_json::from_str::<Value>(&printed).unwrap()["storage"].take();
        (storage["bytes"].as_u64().unwrap(), storage["relative_error"].as_f64().unwrap())
    };
    let [less, more, components, bits] = [
        "--clusters 2 --components 2 --weights 32",
        "--clusters 8 --components 2 --weights 32",
        "--clusters 2 --components 6 --weights 32",
        "--clusters 2 --components 2",
    ]
    .map(storage);
    assert!(less.0 < more.0 && less.1 > more.1, "more clusters: {less:?}, {more:?}");
    assert!(less.0 < components.0 && less.1 > components.1, "more components: {less:?}, {components:?}");
    assert!(bits.0 < less.0 && bits.1 > less.1, "fewer bits: {bits:?}, {less:?}");
    assert_eq!(storage(""), storage("--clusters 128 --components 6 --weights 8"), "the default");
}

#[test]
fn values_out_of_range_and_options_of_other_choices_are_refused() {
    let dir = Dir::new();
    let render = format!("render moving built-in:three-objects {RENDER} -o x.png");
    let spheres = "spheres built-in:ball -n 3 -o s.safetensors";
    for (command, expected) in [
        (format!("{render} --method exponentials --cut 1.5"), "expected a number from 0 to 1, found 1.5"),
        (format!("{render} --method exponentials --group 16 --far -1"), "'-1'"),
        (format!("{render} --method exponentials --far 0.1"), "--far: only of groups of vertices"),
        (format!("{render} --negligible 13"), "from 0 to 4π steradians, found 13"),
        ("spheres table -o t.safetensors --tolerance 0".to_owned(), "expected a number above 0, found 0"),
        ("spheres table -o t.safetensors --tolerance 1e-9".to_owned(), "take a larger one"),
        ("field built-in:ball -o f.safetensors --clusters 3".to_owned(), "--clusters: only of --storage clustered"),
        (
            "field built-in:ball -o f.safetensors --storage u8 --weights 8".to_owned(),
            "--weights: only of --storage clustered",
        ),
        ("lamp sphere --radius 1 --components 3 -o s.safetensors".to_owned(), "--components: only of a rectangle"),
        (format!("{spheres} --no-shrink"), "--no-shrink: only of --method medial-axis"),
    ] {
        let message = dir.lobe(&command).error();
        assert!(message.contains(expected), "{command}: {message}");
    }
}

#[test]
fn balls_of_the_medial_axis_are_larger_as_published() {
    let dir = Dir::new();
    dir.file("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n");
    let outside = |option: &str| {
        let command = format!("spheres t.obj -n 3 --points 600 --method medial-axis {option} -o s.safetensors --json");
        let printed: Value = serde_json::from_str(&dir.lobe(&command).succeeds().0).unwrap();
        printed["outside_volume"].as_f64().unwrap()
    };
    let [shrunk, published] = ["", "--no-shrink"].map(outside);
    assert!(shrunk < published, "{shrunk} where balls shrink, {published} as published");
}
