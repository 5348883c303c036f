//! The program without a window.

use std::path::Path;
use std::process::{Command, Output};

pub(crate) fn viewer(folder: &Path, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lobe-viewer"));
    command.current_dir(folder).args(arguments.split_whitespace()).env("LOBE_VIEWER_FOLDER", folder);
    command.output().unwrap()
}

/// What a failure says: one line, and exit code 2.
fn error(folder: &Path, arguments: &str) -> String {
    let output = viewer(folder, arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments}: {said}");
    assert_eq!(said.lines().count(), 1, "{arguments}: {said}");
    said
}

/// Whether this machine has no graphics adapter, told once.
pub(crate) fn is_without_adapter(output: &Output) -> bool {
    let is_without = String::from_utf8_lossy(&output.stderr).contains("no graphics adapter");
    if is_without {
        lobe_testkit::skipped("pictures of lobe-viewer: no graphics adapter");
    }
    is_without
}

#[test]
fn bad_input_is_one_line_and_exit_code_2() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("bad.glb"), b"nonsense").unwrap();
    std::fs::write(at.join("three.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n").unwrap();
    std::fs::write(at.join("wide.pfm"), [b"PF\n2 1\n-1.0\n".as_slice(), &[0; 24]].concat()).unwrap();
    for (arguments, word) in [
        ("--headless none.glb -o a.png", "none.glb"),
        ("--headless bad.glb -o a.png", "bad.glb"),
        ("--headless built-in:teapot -o a.png", "built-in:ball"),
        ("--headless built-in:ball --env made:midnight -o a.png", "made:evening"),
        ("--headless built-in:ball", "--output"),
        ("--headless built-in:ball --order 9 -o a.png", "--order"),
        ("--headless built-in:ball --size 0x4 -o a.png", "0x4"),
        ("--headless built-in:ball --mode glossy -o a.png", "glossy"),
        ("--headless three.obj --max-triangles 1 -o a.png", "start with a higher --max-triangles"),
        ("--headless three.obj --max-memory 1e-9 -o a.png", "start with a higher --max-memory"),
        ("--headless built-in:ball --env wide.pfm --max-texels 1 -o a.png", "start with a higher --max-texels"),
        ("--headless three.obj --max-memory 0 -o a.png", "--max-memory"),
        ("--headless built-in:ball --mode fields --order 9 -o a.png", "--order"),
        ("--headless built-in:ball --mode fields -o a.png", "built-in:three-objects"),
        ("--bench --mode fields", "--mode fields"),
        ("--json", "--bench"),
        ("--nonsense", "--nonsense"),
    ] {
        let said = error(at, arguments);
        assert!(said.contains(word), "{arguments}: {said}");
    }
}

#[test]
fn a_scene_is_rendered_to_a_file_in_every_mode() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for mode in ["unshadowed", "shadowed", "interreflected", "difference"] {
        let small = "--order 2 --samples 4 --size 32x20 --rays 1 --software";
        let output =
            viewer(at, &format!("--headless built-in:ball --env made:even --mode {mode} {small} -o {mode}.exr"));
        if is_without_adapter(&output) {
            return;
        }
        assert!(output.status.success(), "{mode}: {}", String::from_utf8_lossy(&output.stderr));
        let (picture, _) = lobe::image::read_picture(at.join(format!("{mode}.exr")), &Default::default()).unwrap();
        assert_eq!((picture.width(), picture.height()), (32, 20), "{mode}");
        let mean = picture.mean().iter().sum::<f64>();
        assert!(mean.is_finite() && mean > 0.0, "{mode}: {mean}");
    }
}

#[test]
fn a_measurement_is_a_table_or_json() {
    let folder = tempfile::tempdir().unwrap();
    let small = "--bench --scene built-in:furnace --order 2 --samples 4 --size 32x20 --receivers 500 --software";
    let table = viewer(folder.path(), small);
    if is_without_adapter(&table) {
        return;
    }
    let text = String::from_utf8(table.stdout).unwrap();
    assert!(text.contains("surfaces") && text.contains("frames a second"), "{text}");
    assert!(text.contains("exponentials of 128 spheres at 500 receivers, order 2"), "{text}");
    assert!(text.contains("floor of all passes"), "{text}");
    let json = viewer(folder.path(), &format!("{small} --json")).stdout;
    let value: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert!(value["frames_per_second"].as_f64().is_some_and(|rate| rate > 0.0), "{value}");
    assert_eq!(value["size"], serde_json::json!([32, 20]), "{value}");
    let copied = value["copied_bytes_per_second"].as_f64().unwrap();
    let all = value["passes"].as_array().unwrap().iter().chain([&value["exponentials"]]);
    for pass in all {
        let (bytes, floor) = (pass["bytes"].as_f64().unwrap(), pass["floor_ms"].as_f64().unwrap());
        assert!((floor - 1e3 * bytes / copied).abs() <= 1e-9 * floor, "{pass}: bytes over the speed of a copy");
    }
    assert!(value["exponentials"]["ms"].as_f64().is_some_and(|ms| ms > 0.0), "{value}");
}

#[test]
fn what_moves_is_rendered_moment_by_moment_in_both_ways_and_numbers_may_be_halved() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let wedge = "v 0.5 0 -0.3\nv -0.3 0.4 -0.3\nv -0.3 -0.4 -0.3\nv 0 0 0.5\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    std::fs::write(at.join("wedge.obj"), wedge).unwrap();
    std::fs::write(at.join("ground.obj"), "v -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2\nf 1 2 3\nf 1 3 4\n").unwrap();
    let falls = r#"{"format": "lobe-scene", "version": 1, "still": ["ground.obj"], "entities": [{"name": "falling",
        "mesh": "wedge.obj", "keys": [{"time": 0, "translation": [0, 0, 2]}, {"time": 2, "translation": [0, 0, 1]}]}]}"#;
    std::fs::write(at.join("falls.json"), falls).unwrap();
    let small = "--order 2 --size 40x24 --rays 1 --env made:even --software";
    let read = |name: &str| lobe::image::read_picture(at.join(name), &Default::default()).unwrap().0;
    for mode in ["fields", "exponentials"] {
        let arguments = format!("--headless falls.json --mode {mode} --spheres 4 --frames 2 {small} -o {mode}.exr");
        let output = viewer(at, &arguments);
        if is_without_adapter(&output) {
            return;
        }
        assert!(output.status.success(), "{mode}: {}", String::from_utf8_lossy(&output.stderr));
        let [first, second] = ["0000", "0001"].map(|number| read(&format!("{mode}.{number}.exr")));
        assert_ne!(first.pixels(), second.pixels(), "{mode}: it moves");
    }
    assert_ne!(read("fields.0000.exr").pixels(), read("exponentials.0000.exr").pixels(), "two ways");
    for storage in ["f32", "f16"] {
        let arguments = format!("--headless built-in:ball --samples 4 --storage {storage} {small} -o {storage}.exr");
        assert!(viewer(at, &arguments).status.success(), "{storage}");
    }
    let [whole, half] = ["f32.exr", "f16.exr"].map(read);
    let most = whole.pixels().iter().flatten().fold(0.0_f32, |most, c| most.max(*c));
    let apart = whole.pixels().iter().flatten().zip(half.pixels().iter().flatten()).map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0_f32, f32::max);
    // Half of eleven bits for each number; the sums of a few are as far apart.
    assert!(apart > 0.0 && apart < 2e-3 * most, "{apart} of {most}");
    let said = error(at, "--headless built-in:ball --part wedge.safetensors -o a.png");
    assert!(said.contains("--part wedge.safetensors"), "{said}");
}
