//! `lobe render` of a baked glTF file with an animation: what stands still keeps its transfer where nothing moves near.

use lobe::image::{Picture, compare, read_picture};

use crate::harness::Dir;

/// A glTF file of a floor with a wall, which stand, and a triangle `far` from them, which an animation moves along x.
fn gltf(dir: &Dir, far: f32) {
    let floor =
        [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]];
    let wall =
        [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 1.5, -1.0], [-1.0, 0.0, -1.0], [1.0, 1.5, -1.0], [-1.0, 1.5, -1.0]];
    let moving = [[0.0, 0.6, 0.0], [0.5, 0.6, 0.5], [0.5, 0.6, -0.5_f32]];
    let numbers = [floor.as_flattened(), wall.as_flattened(), moving.as_flattened()].concat();
    let animation = [0.0, 2.0, far, 0.0, 0.0, far + 1.0, 0.0, 0.0];
    let bytes: Vec<u8> = numbers.iter().chain(&animation).flat_map(|x: &f32| x.to_le_bytes()).collect();
    dir.file("a.bin", &bytes);
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1]}}],
            "nodes":[{{"mesh":0}},{{"mesh":1,"translation":[{far},0,0]}}],
            "buffers":[{{"uri":"a.bin","byteLength":{}}}],
            "bufferViews":[{{"buffer":0,"byteLength":144}},{{"buffer":0,"byteOffset":144,"byteLength":36}},
                {{"buffer":0,"byteOffset":180,"byteLength":8}},{{"buffer":0,"byteOffset":188,"byteLength":24}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":12,"type":"VEC3","min":[-1,0,-1],"max":[1,1.5,1]}},
                {{"bufferView":1,"componentType":5126,"count":3,"type":"VEC3","min":[0,0.6,-0.5],"max":[0.5,0.6,0.5]}},
                {{"bufferView":2,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[2]}},
                {{"bufferView":3,"componentType":5126,"count":2,"type":"VEC3"}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}},{{"primitives":[{{"attributes":{{"POSITION":1}}}}]}}],
            "animations":[{{"channels":[{{"sampler":0,"target":{{"node":1,"path":"translation"}}}}],
                "samplers":[{{"input":2,"output":3}}]}}]}}"#,
        bytes.len()
    );
    dir.file("a.gltf", text);
}

const VIEW: &str = "--env bundled:sunset --size 24x18 --eye 3,-5,3 --target 0,0,0.5 --fov 40";

fn picture(dir: &Dir, command: &str) -> (Picture, String) {
    let notes = dir.lobe(&format!("render {command} {VIEW} -o x.exr")).succeeds().1;
    (read_picture(dir.path("x.exr"), &Default::default()).unwrap().0, notes)
}

#[test]
fn what_stands_still_far_from_what_moves_is_shown_as_it_was_baked() {
    let dir = Dir::new();
    gltf(&dir, 300.0);
    dir.lobe("bake a.gltf -o b.glb --no-split --samples 64 --order 3 --quiet").stdout();
    let (still, _) = picture(&dir, "b.glb --mode interreflected");
    let (moving, notes) = picture(&dir, "moving b.glb --time 1");
    assert!(!notes.contains("transfer"), "{notes}");
    let off = compare(moving.pixels(), still.pixels()).relative_rmse;
    assert!(off < 1e-4, "off by {off} of the static picture");
    // A bake anew takes other paths, and as many as it is asked for.
    let (anew, notes) = picture(&dir, "moving b.glb --no-split --time 1 --bounces 1 --bake-samples 8");
    assert!(notes.contains("its transfer is not used: it has 3 reflections, not those that are asked for"), "{notes}");
    let off_anew = compare(anew.pixels(), still.pixels()).relative_rmse;
    assert!(off_anew > 10.0 * off, "{off_anew} by a bake anew, {off} by that of the file");
    let (_, notes) = picture(&dir, "moving b.glb --no-split --time 1 --order 4 --bake-samples 8");
    assert!(notes.contains("its transfer is not used: it has 3 bands, fewer than are asked for"), "{notes}");
}

#[test]
fn what_stood_near_has_no_shadow_where_it_is_no_more() {
    let dir = Dir::new();
    gltf(&dir, 0.0);
    dir.lobe("bake a.gltf -o b.glb --no-split --samples 256 --order 3 --quiet").stdout();
    let (moved, notes) = picture(&dir, "moving b.glb --time 0 --still-points 0");
    let told = notes.lines().filter(|line| line.contains("vertices that stand still keep their transfer")).count();
    assert_eq!(told, 1, "{notes}");
    // The same of a file that is not baked.
    let (anew, _) = picture(&dir, "moving a.gltf --no-split --time 0 --order 3 --bake-samples 256 --still-points 0");
    let off = compare(moved.pixels(), anew.pixels()).relative_rmse;
    assert!(off < 0.02, "off by {off} of a bake of the parts by themselves");
}

#[test]
fn an_animated_entity_of_a_description_keeps_its_transfer_too() {
    let dir = Dir::new();
    gltf(&dir, 300.0);
    dir.lobe("bake a.gltf -o b.glb --no-split --samples 64 --order 3 --quiet").stdout();
    dir.file(
        "s.json",
        r#"{"format":"lobe-scene","version":1,"entities":[{"name":"room","mesh":"b.glb","animation":"0",
            "keys":[{"translation":[0,0,0]}]}]}"#,
    );
    let (still, _) = picture(&dir, "b.glb --mode interreflected");
    let (moving, _) = picture(&dir, "moving s.json --order 3 --time 1 --bake-samples 8");
    let off = compare(moving.pixels(), still.pixels()).relative_rmse;
    assert!(off < 1e-4, "off by {off} of the static picture");
    let error = dir.lobe(&format!("render moving s.json --order 4 {VIEW} --quiet -o y.exr")).error();
    assert!(error.contains("`room: still`: expected its transfer to have 4 bands at least, found 3"), "{error}");
}

#[test]
fn what_stands_in_another_shape_than_it_was_baked_in_is_baked_anew() {
    let dir = Dir::new();
    gltf(&dir, 300.0);
    // Floor and wall have a morph target that makes them larger, half of which is there at rest.
    let text = String::from_utf8(dir.bytes("a.gltf")).unwrap();
    let plain = r#"{"primitives":[{"attributes":{"POSITION":0}}]}"#;
    assert!(text.contains(plain), "{text}");
    let grown = r#"{"primitives":[{"attributes":{"POSITION":0},"targets":[{"POSITION":0}]}],"weights":[0.5]}"#;
    dir.file("a.gltf", text.replace(plain, grown));
    dir.lobe("bake a.gltf -o b.glb --no-split --samples 256 --order 3 --quiet").succeeds();
    let (_, notes) = picture(&dir, "moving b.glb --time 1 --still-points 0");
    assert!(!notes.contains("another shape"), "bakes see morph targets: {notes}");
    // A recipe that does not say when the scene stood so is of a bake without them.
    let mut bytes = dir.bytes("b.glb");
    let time = br#""time":0.0"#;
    let at = bytes.windows(time.len()).position(|found| found == time).expect("a recipe with the time");
    bytes[at..][..time.len()].copy_from_slice(br#""Time":0.0"#);
    dir.file("b.glb", bytes);
    let (kept, notes) = picture(&dir, "moving b.glb --time 1 --still-points 0");
    let told = "0 of 12 vertices that stand still keep their transfer; another animation, skins or morph targets give 12 of the others";
    assert!(notes.contains(told), "{notes}");
    // The same of a file that is not baked.
    let (anew, _) = picture(&dir, "moving a.gltf --no-split --time 1 --order 3 --bake-samples 256 --still-points 0");
    let off = compare(kept.pixels(), anew.pixels()).relative_rmse;
    assert!(off < 0.02, "off by {off} of a bake of the parts as they stand");
}
