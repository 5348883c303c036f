//! Every example runs, and what it asserts holds.

use std::error::Error;

#[path = "../examples/01_project_a_sky.rs"]
mod project_a_sky;

#[path = "../examples/02_light_a_ball.rs"]
mod light_a_ball;

#[path = "../examples/03_turn_the_light.rs"]
mod turn_the_light;

#[path = "../examples/04_remove_ringing.rs"]
mod remove_ringing;

#[path = "../examples/05_find_the_lights.rs"]
mod find_the_lights;

#[path = "../examples/06_convert_a_map.rs"]
mod convert_a_map;

#[path = "../examples/07_take_out_the_sun.rs"]
mod take_out_the_sun;

#[path = "../examples/08_bake_a_scene.rs"]
mod bake_a_scene;

#[path = "../examples/09_compress_and_ship.rs"]
mod compress_and_ship;

#[path = "../examples/10_trace_the_truth.rs"]
mod trace_the_truth;

/// A `main` that says why it failed.
type Main = fn() -> Result<(), Box<dyn Error>>;

const EXAMPLES: [(&str, Main); 10] = [
    ("01_project_a_sky", project_a_sky::main),
    ("02_light_a_ball", light_a_ball::main),
    ("03_turn_the_light", turn_the_light::main),
    ("04_remove_ringing", remove_ringing::main),
    ("05_find_the_lights", find_the_lights::main),
    ("06_convert_a_map", convert_a_map::main),
    ("07_take_out_the_sun", take_out_the_sun::main),
    ("08_bake_a_scene", bake_a_scene::main),
    ("09_compress_and_ship", compress_and_ship::main),
    ("10_trace_the_truth", trace_the_truth::main),
];

#[test]
fn every_example_runs_to_its_end() {
    for (name, main) in EXAMPLES {
        println!("== {name}");
        if let Err(error) = main() {
            panic!("{name}: {error}");
        }
    }
}

#[test]
fn every_example_is_run_and_has_fewer_than_sixty_lines() -> Result<(), Box<dyn Error>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/examples"))? {
        let path = entry?.path();
        let lines = std::fs::read_to_string(&path)?.lines().count();
        assert!(lines < 60, "{}: {lines} lines", path.display());
        found.extend(path.file_stem().map(|name| name.to_string_lossy().into_owned()));
    }
    found.sort();
    assert_eq!(found, EXAMPLES.map(|(name, _)| name), "the files in the folder, and the examples that are run");
    Ok(())
}
