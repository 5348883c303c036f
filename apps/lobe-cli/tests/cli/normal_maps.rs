//! Normal maps: in which bakes and pictures they are, and what is said where they are not.

use lobe::prt::read_transfer;
use lobe::scene::{GltfDocument, Material, Mesh, MeshParts, NormalMap, Scene, Texture, TextureUse, Wrap};
use serde_json::json;

use crate::harness::{Dir, mean};

/// A folder with a square that faces up, unfolded for a lightmap, tilted along x by a normal map (a.gltf) or not (flat.gltf).
fn squares() -> Dir {
    let dir = Dir::new();
    let uvs = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let parts = MeshParts {
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uvs: [uvs, vec![]],
        material: Some(0),
        ..MeshParts::default()
    };
    let used = TextureUse { texture: 0, uv_set: 0, uv_map: TextureUse::UV_UNCHANGED };
    let material = Material { normal_map: Some(NormalMap { used, scale: 1.0 }), ..Material::WHITE };
    let texture = Texture::new(1, 1, vec![[255, 128, 255, 255]], [Wrap::Repeat; 2]);
    let mesh = Mesh::new(parts).unwrap().with_tangents(0);
    let bumpy = Scene::new(vec![mesh], vec![material], vec![texture]).unwrap();
    for (name, scene) in [("a", bumpy.clone()), ("flat", bumpy.without_normal_maps())] {
        let GltfDocument { mut json, bytes } = GltfDocument::of_scene(&scene);
        dir.file(&format!("{name}.bin"), &bytes);
        json["buffers"][0]["uri"] = json!(format!("{name}.bin"));
        dir.file(&format!("{name}.gltf"), json.to_string());
    }
    dir
}

const NOTE: &str = "note: a.gltf: has normal maps, which transfer at vertices does not hold";

#[test]
fn a_bake_at_vertices_says_that_one_at_texels_holds_normal_maps() {
    let dir = squares();
    let bake = |scene: &str, more: &str| {
        let args = format!("bake {scene}.gltf --mode unshadowed --order 2 --samples 1 --fresh {more}");
        dir.lobe(&args).succeeds().1
    };
    let notes = bake("a", "-o v.safetensors");
    assert!(notes.contains(NOTE) && notes.contains("--texels"), "{notes}");
    for (scene, more) in [("a", "--texels 4 -o t.safetensors"), ("flat", "-o f.safetensors")] {
        let notes = bake(scene, more);
        assert!(!notes.contains("normal map"), "{scene} {more}: {notes}");
    }
    // Glossy transfer is not baked at texels, and pictures by it tilt the view that is mirrored.
    let (_, notes) = dir.lobe("bake a.gltf --mode glossy --order 2 --samples 4 -o g.safetensors").succeeds();
    assert!(!notes.contains("normal map"), "glossy: {notes}");
    // The last function of band 1 is that of -x: of a normal between +x and +z it is as large as that of z.
    let at = |name: &str| read_transfer(dir.path(name)).unwrap().0.vector(0, 0).to_vec();
    let (texel, vertex) = (at("t.safetensors"), at("v.safetensors"));
    assert!((texel[3] + texel[2]).abs() < 1e-5 && texel[2] > 0.1, "at a texel: {texel:?}");
    assert!(vertex[3].abs() < 1e-5 && vertex[2] > 0.1, "at a vertex: {vertex:?}");
}

#[test]
fn pictures_of_truth_and_irradiance_show_normal_maps_and_those_of_vertices_say_that_they_do_not() {
    let dir = squares();
    // More light from the side of +x, which is in the middle.
    dir.map("sky.exr", 32, 16, |x, _| [if (8..24).contains(&x) { 1.0 } else { 0.2 }; 3]);
    let view = "--env sky.exr --size 4x3 --eye 0.3,-0.5,6 --target 0,0,0 --fov 10";
    let render = |scene: &str, mode: &str| {
        let (_, notes) = dir.lobe(&format!("render {mode} {scene}.gltf {view} -o {scene}.exr")).succeeds();
        (mean(&dir.numbers(&format!("{scene}.exr"))), notes)
    };
    for mode in ["irradiance", "trace --bounces 0 --samples 256"] {
        let [(tilted, notes), (flat, _)] = ["a", "flat"].map(|scene| render(scene, mode));
        // It tilts towards the brighter half, of which the triangle hides less, in the truth, than is gained.
        assert!(tilted > 1.02 * flat, "{mode}: {tilted} with a normal map, {flat} without");
        assert!(!notes.contains("normal map"), "{mode}: {notes}");
    }
    let [(with, notes), (without, _)] = ["a", "flat"].map(|scene| render(scene, "baked --mode unshadowed"));
    assert!((with - without).abs() < 1e-6, "transfer at vertices: {with} and {without}");
    assert!(notes.contains(NOTE) && notes.contains("a bake to --texels does"), "{notes}");
}

#[test]
fn a_normal_texture_that_is_missing_is_named_in_one_line() {
    let dir = squares();
    let text = String::from_utf8(dir.bytes("a.gltf")).unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
    json["images"][0] = json!({"uri": "bumps.png"});
    dir.file("lost.gltf", json.to_string());
    let line = dir.lobe("bake lost.gltf --samples 1 -o a.glb --quiet").error();
    assert!(line.contains("bumps.png, named by lost.gltf"), "{line}");
    // What looks at shapes alone does not need it.
    let field = "field lost.gltf --order 2 --spheres 3 --cells 4 --rays 4 -o f.safetensors";
    let (_, notes) = dir.lobe(field).succeeds();
    assert!(notes.contains("has a normal texture, which is not used"), "{notes}");
    dir.file("bumps.png", "no picture");
    let line = dir.lobe("bake lost.gltf --samples 1 -o a.glb --quiet").error();
    assert!(
        line.contains("lost.gltf: image 0: expected a PNG, JPEG, WebP or KTX2, found another kind of file"),
        "{line}"
    );
}
