//! `lobe field`, `lobe spheres`, and `lobe render` of scenes that move.

use serde_json::Value;

use crate::harness::Dir;

const VIEW: &str = "--env bundled:sunset --size 32x24 --bake-samples 16 --order 3";

#[test]
fn a_field_is_baked_and_shadows_a_scene_in_files() {
    let dir = Dir::new();
    let field = "field built-in:ball -o ball.field.safetensors --order 3 --spheres 4 --cells 4 --rays 16 --json";
    let printed: Value = serde_json::from_str(&dir.lobe(field).succeeds().0).unwrap();
    assert_eq!(printed["points"], 4 * 5 * 5 + 1, "{printed}");
    dir.file(
        "scene.json",
        r#"{"format":"lobe-scene","version":1,"still":"built-in:terrain","entities":[
            {"name":"ball","mesh":"built-in:ball","field":"ball.field.safetensors",
             "keys":[{"translation":[0,0,3],"scale":0.3}]}]}"#,
    );
    dir.lobe(&format!("render moving scene.json {VIEW} --no-split -o moving.png")).succeeds();
    assert!(dir.path("moving.png").exists(), "no picture");
}

#[test]
fn the_field_of_an_entity_is_that_of_the_entity_alone() {
    use lobe::shadow::{FieldOptions, FieldStorage, bake_field, read_visibility, write_field};
    let dir = Dir::new();
    let bake = "field built-in:walking-figure --order 2 --rays 4";
    let (_, notes) = dir.lobe(&format!("{bake} --spheres 3 --cells 4 --entity figure -o a.safetensors")).succeeds();
    assert!(notes.contains("this entity is deformed") && notes.contains("spheres of an --entity do"), "{notes}");
    let moving = lobe::scene::built_in::moving("walking-figure").unwrap();
    let own = moving.own_scene(moving.entity("figure").unwrap()).unwrap();
    let options = FieldOptions::default().order(2).spheres(3).cells(4).rays(4);
    let (field, _) = bake_field(&own, &options, Default::default()).unwrap();
    write_field(dir.path("b.safetensors"), &field, &FieldStorage::F32).unwrap();
    assert!(dir.bytes("a.safetensors") == dir.bytes("b.safetensors"), "the bytes of the library");
    let (_, notes) = dir.lobe(&format!("{bake} --entity figure --self-visibility -o v.safetensors")).succeeds();
    assert!(notes.contains("this entity is deformed"), "{notes}");
    let visibility = read_visibility(dir.path("v.safetensors")).unwrap();
    assert_eq!(visibility.rows().len(), own.vertex_count() * 4, "a row for each vertex of the entity");
    let error = dir.lobe(&format!("{bake} --entity nobody -o f.safetensors")).error();
    assert_eq!(error, "found no entity `nobody` in the scene: expected one of `ground`, `figure`", "");
    let error = dir.lobe(&format!("{bake} -o f.safetensors")).error();
    assert!(error.contains("built-in:walking-figure: moves; ") && error.contains("--entity NAME"), "{error}");
}

#[test]
fn spheres_are_fitted_and_their_table_is_written() {
    let dir = Dir::new();
    dir.file("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n");
    let spheres = "spheres t.obj -n 3 --points 300 --rounds 2 -o s.safetensors --json";
    let printed: Value = serde_json::from_str(&dir.lobe(spheres).succeeds().0).unwrap();
    assert_eq!(printed["spheres"].as_array().map(Vec::len), Some(3), "{printed}");
    // The union covers the solid, and the sum counts overlaps again.
    let volume = |name: &str| printed[name].as_f64().unwrap();
    let outside = volume("union_volume") - volume("solid_volume");
    assert!(outside > 0.0 && outside < volume("outside_volume") * 1.001, "{printed}");
    let (table, _) = dir.lobe("spheres table -o t.safetensors --order 3").succeeds();
    assert!(table.contains("order           3"), "{table}");
}

#[test]
#[ignore = "long: of the nightly group"]
fn frames_of_a_moving_scene_are_numbered_by_their_times() {
    let dir = Dir::new();
    let shexp = "moving --method exponentials --spheres 2 --exponential hybrid";
    dir.lobe(&format!("render {shexp} built-in:three-objects {VIEW} --frames 3..4 --fps 2 -o turn.png")).succeeds();
    for name in ["turn-003.png", "turn-004.png", "turn.png"] {
        assert!(dir.path(name).exists(), "no {name}");
    }
    dir.lobe(&format!("render {shexp} built-in:three-objects {VIEW} --time 1.5 -o one.png --exposure 0")).succeeds();
    dir.lobe(&format!("render {shexp} built-in:three-objects {VIEW} --frames 3..3 --fps 2 -o same.png --exposure 0"))
        .succeeds();
    assert!(dir.bytes("one.png") == dir.bytes("same-003.png"), "frame 3 of 2 a second is at 1.5 s");
}

#[test]
#[ignore = "long: of the nightly group"]
fn fields_are_smooth_and_spheres_shared_by_neighbors_where_asked() {
    let dir = Dir::new();
    let picture = |name: &str, options: &str| {
        let command = format!("render {options} built-in:three-objects {VIEW} --time 1 -o {name}");
        dir.lobe(&command).succeeds();
    };
    picture("linear.exr", "moving");
    picture("cubic.exr", "moving --interpolation cubic");
    picture("alone.exr", "moving --method exponentials --spheres 4");
    picture("groups.exr", "moving --method exponentials --spheres 4 --group 64");
    for (a, b) in [("linear.exr", "cubic.exr"), ("alone.exr", "groups.exr")] {
        let (printed, _) = dir.lobe(&format!("compare {a} {b} --json")).succeeds();
        let psnr = serde_json::from_str::<Value>(&printed).unwrap()["psnr"].as_f64().unwrap();
        assert!(psnr > 40.0 && psnr.is_finite(), "{a} and {b} are near each other and not the same: {psnr}");
    }
}

#[test]
fn options_that_would_be_ignored_or_contradict_each_other_are_refused() {
    let dir = Dir::new();
    for (options, expected) in [
        ("baked --time 1", "built-in:three-objects: moves; show it by lobe render moving or lobe render trace"),
        ("irradiance", "built-in:three-objects: moves; show it by lobe render moving or lobe render trace"),
        ("moving --order 9", "--order: shadows of what moves have an order of 1 to 8"),
        ("moving --still-points 4", "expected 0, or 8 points at least, found 4"),
        ("moving --max-triangles 4", "--max-triangles: only of scenes in files"),
        ("moving --up z", "--up: only .obj or .ply files"),
        ("moving --method exponentials --group 20", "expected a multiple of 16, found 20"),
        ("moving --exponential grid", "--exponential: only of --method exponentials"),
        ("moving --fps 3", "--fps: only of --frames A..B"),
        ("moving --time 1 --frames 0..3", "--time: --frames A..B says the times"),
        ("moving --frames 3..0", "in order"),
        ("moving --animation none", "found no animation `none`"),
    ] {
        let command = format!("render {options} built-in:three-objects --env bundled:sunset -o x.png --quiet");
        let message = dir.lobe(&command).error();
        assert!(message.contains(expected), "{options}: {message}");
    }
    let message = dir.lobe("bake built-in:three-objects -o b.glb").error();
    assert!(
        message.contains("built-in:three-objects: moves; lobe render moving and lobe render trace show it"),
        "{message}"
    );
    let message = dir.lobe("spheres --quiet").error();
    assert!(message.contains("lobe spheres --help"), "{message}");
    let message = dir.lobe("spheres table -o t.safetensors --clamp 7").error();
    assert!(message.contains("expected a part above 0 and up to 1, found 7"), "{message}");
    let message = dir.lobe("field built-in:ball -o f.safetensors --cells 5").error();
    assert!(message.contains("even number of cells"), "{message}");
    let message = dir.lobe("spheres built-in:ball -n 3 --method medial-axis --rounds 3 -o s.safetensors").error();
    assert!(message.contains("--rounds: only of --method variational"), "{message}");
}

#[test]
fn the_visibility_of_an_entity_itself_is_that_of_the_library() {
    use lobe::shadow::{VisibilityOptions, bake_vertex_visibility, read_visibility};
    let dir = Dir::new();
    let command = "field built-in:ball --self-visibility --order 3 --rays 64 --seed 2 -o v.safetensors --json";
    let printed: Value = serde_json::from_str(&dir.lobe(command).succeeds().0).unwrap();
    let scene = lobe::scene::built_in::named("ball").unwrap();
    assert_eq!(printed["vertices"], scene.vertex_count(), "{printed}");
    let positions: Vec<_> = scene.meshes().iter().flat_map(lobe::scene::Mesh::positions).copied().collect();
    let options = VisibilityOptions::default().order(3).rays(64).seed(2);
    let (expected, rays) = bake_vertex_visibility(&scene, &options, Default::default()).unwrap();
    assert_eq!(printed["rays"], rays, "{printed}");
    let found = read_visibility(dir.path("v.safetensors")).unwrap();
    assert!(found.order() == 3 && found.rows() == expected, "the numbers of the library");
    assert_eq!(found.positions(), Some(&*positions), "where each vertex is");
    assert_eq!(dir.names(), ["v.safetensors"], "no checkpoint is left");
    for option in ["--spheres 4", "--cells 4", "--range 1,2", "--shard 1/2"] {
        let message = dir.lobe(&format!("{command} {option}")).error();
        assert!(
            message.contains("--self-visibility") && message.trim_end().lines().count() == 1,
            "{option}: {message}"
        );
    }
}
