//! Options of reading scenes.

use lobe::scene::{GltfDocument, built_in};
use serde_json::json;

use crate::harness::Dir;

/// A folder with a secret, and a scene in a folder of that, changed.
fn beside_a_secret(change: impl FnOnce(&mut serde_json::Value)) -> Dir {
    let dir = Dir::new();
    std::fs::create_dir(dir.path("in")).unwrap();
    dir.file("secret.txt", "a secret of nobody but its owner");
    let GltfDocument { mut json, bytes } = GltfDocument::of_scene(&built_in::closed_white_box(1));
    dir.file("in/data.bin", &bytes);
    json["buffers"][0]["uri"] = json!("data.bin");
    change(&mut json);
    dir.file("in/a.gltf", json.to_string());
    dir
}

const BAKE: &str = "bake in/a.gltf --mode unshadowed --samples 4 --order 1 -o out.glb";

fn has_secret(bytes: &[u8]) -> bool {
    bytes.windows(8).any(|part| part == b"a secret")
}

#[test]
fn files_outside_of_the_folder_are_in_a_bake_only_if_the_scene_is_trusted() {
    let unused = beside_a_secret(|json| {
        json["buffers"].as_array_mut().unwrap().push(json!({"uri": "../secret.txt", "byteLength": 8}));
    });
    unused.lobe(BAKE).succeeds();
    assert!(!has_secret(&unused.bytes("out.glb")), "a buffer that nothing uses");

    let viewed = beside_a_secret(|json| {
        let buffers = json["buffers"].as_array_mut().unwrap();
        buffers.push(json!({"uri": "../secret.txt", "byteLength": 8}));
        let buffer = buffers.len() - 1;
        let views = json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": buffer, "byteLength": 8}));
        let view = views.len() - 1;
        json["extras"] = json!({"bufferView": view});
    });
    let line = viewed.lobe(BAKE).arg("--quiet").error();
    let expected = "in/a.gltf: names the file `../secret.txt`, which is outside of its folder: move it there, or trust the \
                    file with --allow-outside";
    assert!(line.contains(expected), "{line}");
    assert!(!viewed.names().contains(&"out.glb".to_owned()), "nothing is written");
    viewed.lobe(BAKE).arg("--allow-outside").succeeds();
    assert!(has_secret(&viewed.bytes("out.glb")), "trusted");
}

#[test]
fn options_of_reading_that_would_be_ignored_are_refused() {
    let dir = Dir::new();
    dir.file("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
    for (scene, option, expected) in [
        ("built-in:ball", "--allow-outside", "--allow-outside: only of scenes in files; leave the option out"),
        ("built-in:ball", "--missing-normals=flat", "--missing-normals: only of scenes in files; leave the option out"),
        ("a.obj", "--default-material=gltf", "--default-material: only of glTF files"),
    ] {
        let line = dir.lobe(&format!("bake {scene} -o a.glb --quiet {option}")).error();
        assert!(line.contains(expected), "{option}: {line}");
    }
}

#[test]
fn the_normals_of_a_bake_are_those_that_were_asked_for() {
    let dir = Dir::new();
    dir.file("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nf 1 2 3 4\nf 2 1 5 6\n");
    for (option, vertices) in [("", 6), ("--missing-normals smooth", 6), ("--missing-normals flat", 8)] {
        dir.lobe(&format!("bake a.obj --samples 4 --order 1 -o out.glb --fresh --no-split {option}")).succeeds();
        assert_eq!(dir.baked("out.glb").scene.vertex_count(), vertices, "{option}");
    }
}
