//! `lobe render --surfaces gltf`: materials on baked scenes and on scenes that move, beside the truth.

use lobe::image::{PictureReadOptions, read_picture};
use lobe::scene::{
    GltfDocument, Hit, Material, Mesh, MeshParts, Scene, SceneReadOptions, Texture, TextureUse, Wrap, read_scene,
};
use serde_json::{Value, json};

use crate::harness::Dir;

/// The relative error of a picture over surfaces against two traced halves.
fn error(dir: &Dir, picture: &str) -> f64 {
    let compared = format!("compare {picture} a.exr --half b.exr --json");
    let found: Value = serde_json::from_str(&dir.lobe(&compared).arg("--quiet").stdout()).unwrap();
    found["surfaces"]["relative_rms"].as_f64().unwrap()
}

#[test]
fn baked_metals_are_nearer_to_the_truth_by_their_material_than_matte() {
    let dir = Dir::new();
    let finish = "--surfaces gltf --metallic 1 --roughness 0.3";
    let view = "built-in:ball --env bundled:sunset --size 32x24 --background none";
    for (name, seed) in [("a", 1), ("b", 2)] {
        let trace = format!("render trace {view} {finish} --samples 64 --seed {seed} -o {name}.exr");
        dir.lobe(&trace).succeeds();
    }
    let bake = "--bake-samples 64 --no-split";
    dir.lobe(&format!("render {view} {bake} {finish} -o metal.exr")).succeeds();
    dir.lobe(&format!("render {view} {bake} -o matte.exr")).succeeds();
    let (metal, matte) = (error(&dir, "metal.exr"), error(&dir, "matte.exr"));
    // Ground and ball reflect each other by few bands.
    assert!(metal < 0.7 * matte, "{metal} as metal, {matte} as matte");
}

#[test]
fn moving_scenes_show_materials_at_every_order() {
    let dir = Dir::new();
    let mean = |name: &str| read_picture(dir.path(name), &PictureReadOptions::default()).unwrap().0.mean()[1];
    for order in [1, 2, 4] {
        let render = format!(
            "render moving built-in:three-objects --env bundled:sunset --size 16x12 --bake-samples 4 --bounces 0 \
             --no-split --order {order}"
        );
        dir.lobe(&format!("{render} --surfaces gltf -o gltf.exr")).succeeds();
        dir.lobe(&format!("{render} -o matte.exr")).succeeds();
        let (gltf, matte) = (mean("gltf.exr"), mean("matte.exr"));
        assert!(gltf != matte && (gltf / matte - 1.0).abs() < 0.3, "order {order}: {gltf}, matte {matte}");
    }
}

#[test]
fn a_scene_with_metals_that_is_shown_matte_has_a_note() {
    let dir = Dir::new();
    let render = "render trace built-in:still-life --env bundled:sunset --size 8x6 --samples 2";
    let (_, notes) = dir.lobe(&format!("{render} -o a.exr")).succeeds();
    assert!(notes.contains("--surfaces gltf shows them"), "{notes}");
    for asked in ["--surfaces gltf", "--surfaces matte"] {
        let (_, notes) = dir.lobe(&format!("{render} {asked} -o a.exr")).succeeds();
        assert!(!notes.contains("shows them"), "{asked}: {notes}");
    }
}

/// A folder with a square whose color and whose metallic, half of its factor, are in textures.
fn textured_square() -> Dir {
    let uvs = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let parts = MeshParts {
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uvs: [uvs, vec![]],
        material: Some(0),
        ..MeshParts::default()
    };
    let of = |texture| Some(TextureUse { texture, uv_set: 0, uv_map: TextureUse::UV_UNCHANGED });
    let [metallic_texture, roughness_texture, base_color_texture] = [of(0), of(0), of(1)];
    let material =
        Material { metallic: 1.0, metallic_texture, roughness_texture, base_color_texture, ..Material::WHITE };
    let texture = |texel| Texture::new(1, 1, vec![texel], [Wrap::Repeat; 2]);
    let textures = vec![texture([0, 200, 128, 255]), texture([200, 100, 50, 255])];
    let scene = Scene::new(vec![Mesh::new(parts).unwrap()], vec![material], textures).unwrap();
    let GltfDocument { mut json, bytes } = GltfDocument::of_scene(&scene);
    let dir = Dir::new();
    dir.file("a.bin", &bytes);
    json["buffers"][0]["uri"] = json!("a.bin");
    dir.file("a.gltf", json.to_string());
    dir
}

#[test]
fn an_unwrapped_scene_keeps_the_textures_of_its_materials() {
    let dir = textured_square();
    dir.lobe("bake a.gltf --mode unshadowed --order 2 --samples 1 --texels 16 --unwrap always -o a.glb").succeeds();
    let (scene, _) = read_scene(dir.path("a.glb"), &SceneReadOptions::default().finish(true)).unwrap();
    let found = scene.finish(&Hit { t: 1.0, triangle: 0, u: 0.25, v: 0.25 });
    assert!((found.metallic - 128.0 / 255.0).abs() < 1e-6, "{found:?}");
}

#[test]
fn a_lightmap_in_a_file_of_its_own_is_that_of_the_scene_with_its_materials() {
    let dir = textured_square();
    let bake = "bake a.gltf --mode unshadowed --order 2 --samples 1 --texels 16";
    dir.lobe(&format!("{bake} -o a.exr")).succeeds();
    let render = "render a.gltf --transfer a.exr --mode unshadowed --env bundled:sunset --size 8x6";
    for surfaces in ["matte", "gltf"] {
        dir.lobe(&format!("{render} --surfaces {surfaces} -o {surfaces}.exr")).succeeds();
    }
}
