//! `lobe compress` and `lobe fit-lobes`: compressed and zonal transfer.

use lobe::io::Job;
use lobe::prt::{Channels, Recipe, Transfer, read_compressed_transfer, read_zonal_transfer, write_transfer};
use lobe::sh::{Dir as Direction, Zonal};
use lobe_testkit::fibonacci_sphere;
use serde_json::Value;

use crate::harness::Dir;

/// Unshadowed vertices that face everywhere.
fn ball() -> Transfer {
    let cosine = Zonal::clamped_cosine(3);
    let vectors =
        fibonacci_sphere(200).into_iter().map(|n| cosine.towards(Direction::from_unit(n), 1.0_f32).into_vec());
    Transfer::new(3, Channels::Gray, vectors.flatten().collect()).unwrap()
}

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} of {row} is no number"))
}

#[test]
fn transfer_is_compressed_and_the_curve_falls() {
    let dir = Dir::new();
    write_transfer(
        dir.path("t.safetensors"),
        &ball(),
        &Recipe::default().seed(5).scene_hash("ab".to_owned()),
        Job::default(),
    )
    .unwrap();
    let args = "compress t.safetensors -o c.safetensors --clusters 16 --components 2 --weights 8 --curve --json";
    let found: Value = serde_json::from_str(&dir.lobe(args).stdout()).unwrap();
    let (compressed, recipe) = read_compressed_transfer(dir.path("c.safetensors")).unwrap();
    assert_eq!((recipe.seed, recipe.scene_hash.as_deref()), (Some(5), Some("ab")), "the recipe of the bake");
    assert_eq!((recipe.clusters, recipe.weights), (Some(16), Some(8)), "and its own");
    assert_eq!(number(&found, "receivers"), 200.0, "receivers");
    assert_eq!(number(&found, "bytes"), compressed.table().bytes() as f64, "bytes");
    assert!(number(&found, "relative_error") < 0.1, "{found}");
    let curve = found["curve"].as_array().unwrap();
    assert_eq!(curve.len(), 9, "0, 1, 2 components with 1, 4, 16 clusters");
    let (first, last) = (number(&curve[0], "squared_error"), number(&curve[8], "squared_error"));
    assert!(last < 0.1 * first, "{first} falls to {last}");
    let text = dir.lobe("compress t.safetensors -o c.safetensors --clusters 1 --components 9").stdout();
    assert!(text.contains("components      9") && text.contains("times fewer"), "{text}");
}

#[test]
fn compressed_transfer_and_lobes_are_rendered_as_the_transfer_they_stand_for() {
    let dir = Dir::new();
    let view = "--env bundled:sunset --rotate-light 40 --size 64x48 --quiet";
    dir.lobe("bake built-in:ball -o b.glb --no-split --order 3 --samples 64 --mode shadowed").succeeds();
    dir.lobe("bake built-in:ball -o p.safetensors --order 3 --samples 64 --mode shadowed --clusters 8 --components 8")
        .succeeds();
    dir.lobe("compress b.glb -o c.safetensors --clusters 8 --components 8 --weights 16").succeeds();
    dir.lobe("fit-lobes b.glb -o z.safetensors --closed-form").succeeds();
    let found: Value =
        serde_json::from_str(&dir.lobe("compress b.glb -o h.safetensors --f16 --json").stdout()).unwrap();
    let recipe = lobe::prt::read_transfer(dir.path("h.safetensors")).unwrap().1;
    assert_eq!(recipe.relative_error, Some(number(&found, "relative_error")), "the error is in the recipe");
    dir.lobe("compress h.safetensors -o again.safetensors --f16").succeeds();
    let again = lobe::prt::read_transfer(dir.path("again.safetensors")).unwrap().1;
    assert_eq!(again.relative_error, recipe.relative_error, "what was lost before is not forgotten");
    assert_eq!((number(&found, "ratio"), number(&found, "relative_error") < 2.0_f64.powi(-11)), (2.0, true), "{found}");
    let picture = |scene: &str, name: &str| {
        dir.lobe(&format!("render {scene} {view} --mode shadowed -o {name}.exr")).succeeds();
        read_env_picture(&dir, &format!("{name}.exr"))
    };
    let plain = picture("b.glb", "plain");
    let largest = plain.iter().copied().fold(0.0, f32::max);
    // The forms differ by their errors: 8 components of 9 lose next to nothing, one lobe some hundredths.
    for (name, limit) in [("c", 2e-3), ("p", 2e-3), ("z", 0.3), ("h", 5e-4)] {
        let found = picture(&format!("built-in:ball --transfer {name}.safetensors"), name);
        let worst = plain.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / largest;
        assert!(worst < limit, "{name}: {worst} of the largest value");
        assert!(worst > 0.0, "{name} is another form");
    }
    let line =
        dir.lobe(&format!("render built-in:cave --transfer c.safetensors {view} --mode shadowed -o x.exr")).error();
    assert!(line.starts_with("c.safetensors: expected transfer of"), "{line}");
    let line = dir.lobe("compress b.glb -o c.safetensors --f16 --clusters 4").error();
    assert!(line.contains("'--f16' cannot be used with '--clusters"), "{line}");
    let line = dir.lobe("compress b.glb -o c.glb").error();
    assert_eq!(line, "-o: expected a name that ends in .safetensors, found c.glb", "another kind of file");
    for args in
        ["compress c.safetensors -o c.safetensors", "bake b.glb -o b.glb", "fit-lobes c.safetensors -o ./c.safetensors"]
    {
        let line = dir.lobe(args).error();
        assert!(line.ends_with("is an input, which would be lost; give another name"), "{args}: {line}");
    }
}

/// All numbers of a picture.
fn read_env_picture(dir: &Dir, name: &str) -> Vec<f32> {
    let picture = lobe::image::read_picture(dir.path(name), &lobe::image::PictureReadOptions::default()).unwrap().0;
    picture.pixels().as_flattened().to_vec()
}

#[test]
fn transfer_without_a_place_in_16_bits_is_refused_by_its_name() {
    let dir = Dir::new();
    let large = Transfer::new(1, Channels::Gray, vec![0.5, 70000.0]).unwrap();
    write_transfer(dir.path("t.safetensors"), &large, &Recipe::default(), Job::default()).unwrap();
    let line = dir.lobe("compress t.safetensors -o h.safetensors --f16").error();
    let expected =
        "t.safetensors: transfer of 16 bits: expected coefficients below 65520 in size, found 70000 at receiver 1";
    assert_eq!(line, expected, "what, where and by how much");
    assert!(!dir.path("h.safetensors").exists(), "nothing is left behind");
}

#[test]
fn a_lobe_for_each_vertex_is_fitted() {
    let dir = Dir::new();
    write_transfer(
        dir.path("t.safetensors"),
        &ball(),
        &Recipe::default().seed(5).scene_hash("ab".to_owned()),
        Job::default(),
    )
    .unwrap();
    let found: Value =
        serde_json::from_str(&dir.lobe("fit-lobes t.safetensors -o z.safetensors --json").stdout()).unwrap();
    assert!(number(&found, "worst_relative_error") < 1e-6, "unshadowed transfer is one lobe: {found}");
    let (zonal, recipe) = read_zonal_transfer(dir.path("z.safetensors")).unwrap();
    assert_eq!((recipe.seed, recipe.lobes), (Some(5), Some(1)), "the recipe of the bake, and its own");
    assert_eq!((zonal.receivers(), zonal.lobes()), (200, 1), "lobes");
}
