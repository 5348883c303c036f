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
fn is_without_adapter(output: &Output) -> bool {
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
        ("--headless outside.obj --max-memory 0 -o a.png", "--max-memory"),
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
    let small = "--bench --scene built-in:furnace --order 2 --samples 4 --size 32x20 --software";
    let table = viewer(folder.path(), small);
    if is_without_adapter(&table) {
        return;
    }
    let text = String::from_utf8(table.stdout).unwrap();
    assert!(text.contains("surfaces") && text.contains("frames a second"), "{text}");
    let json = viewer(folder.path(), &format!("{small} --json")).stdout;
    let value: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert!(value["frames_per_second"].as_f64().is_some_and(|rate| rate > 0.0), "{value}");
    assert_eq!(value["size"], serde_json::json!([32, 20]), "{value}");
}
