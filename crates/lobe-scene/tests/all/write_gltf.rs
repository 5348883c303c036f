//! Scenes written as glTF and read again.

use lobe_scene::{
    Alpha, GltfDocument, Material, Mesh, MeshParts, NormalMap, OcclusionMap, Scene, SceneReadOptions, Texture,
    TextureUse, Wrap, built_in, read_scene_bytes,
};
use serde_json::json;

use crate::common::Gltf;

fn written(scene: &Scene) -> Gltf {
    let GltfDocument { json, bytes } = GltfDocument::of_scene(scene);
    Gltf { json, buffer: bytes }
}

fn again(scene: &Scene) -> Scene {
    let options = SceneReadOptions::default().finish(true);
    read_scene_bytes(&written(scene).glb(), "again.glb", &options).unwrap().0
}

#[test]
fn every_member_of_a_material_comes_back() {
    let uv_map = [[2.0, 0.0, 0.5], [0.0, 4.0, 0.25]];
    let used = TextureUse { texture: 0, uv_set: 1, uv_map };
    let mut materials = vec![
        Material {
            name: "everything".to_owned(),
            base_color: [0.25, 0.5, 0.75, 0.5],
            base_color_texture: Some(used),
            normal_map: Some(NormalMap { used, scale: 0.5 }),
            alpha: Alpha::Mask(0.25),
            double_sided: false,
            metallic: 0.25,
            metallic_texture: Some(used),
            roughness: 0.5,
            roughness_texture: Some(used),
            occlusion_map: Some(OcclusionMap { used, strength: 0.25 }),
            // Brighter than a factor may be.
            emissive: [1.0, 0.5, 2.0],
            emissive_texture: Some(used),
            transmission: 0.75,
            straight_through: false,
        },
        Material { name: "film".to_owned(), alpha: Alpha::Blend, transmission: 0.5, ..Material::WHITE },
    ];
    let parts = MeshParts {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        uvs: [vec![], vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]],
        material: Some(0),
        ..MeshParts::default()
    };
    let texture = Texture::new(1, 1, vec![[255, 255, 0, 128]], [Wrap::Mirror, Wrap::Clamp]);
    let scene = Scene::new(vec![Mesh::new(parts).unwrap()], materials.clone(), vec![texture]).unwrap();
    assert_eq!(again(&scene).materials(), materials, "read again");
    let json = written(&scene).json;
    let names = json!(["KHR_texture_transform", "KHR_materials_emissive_strength", "KHR_materials_transmission"]);
    assert_eq!(json["extensionsUsed"], names, "each is named once");
    // Whether light goes straight through is a matter of the reader.
    materials.iter_mut().for_each(|material| material.straight_through = true);
    let see_through = scene.with_straight_through(true);
    assert_eq!(see_through.materials(), materials, "with light straight through");
    assert_eq!(written(&see_through).json, json, "the file does not say so");
}

#[test]
fn an_origin_that_f32_cannot_hold_comes_back_with_the_same_positions() {
    for place in [[1e7 + 0.3, 0.0, 0.0], [1e7 + 0.3, -2e6 - 0.7, 1e5], [-123_456_789.125, 0.0, 1.0 / 3.0 + 1e9]] {
        let scene = built_in::ball_over_ground(8).moved(place);
        let found = again(&scene);
        assert_eq!(found.origin(), place, "the origin");
        for (a, b) in scene.meshes().iter().zip(found.meshes()) {
            assert!(a.positions() == b.positions(), "positions of {} at {place:?}", a.name());
        }
        // For programs of f32 the nodes of meshes have numbers that they hold.
        let file = written(&scene);
        let translation = file.json["nodes"][0]["translation"].as_array().unwrap();
        for number in translation.iter().map(|number| number.as_f64().unwrap()) {
            assert_eq!(f64::from(number as f32), number, "the node of a mesh");
        }
    }
}

#[test]
fn transforms_have_the_digits_of_the_file() {
    let file = Gltf::square().with("/nodes/0/translation", json!([1_234_567.891, 0.0, 0.0]));
    let scene = read_scene_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).unwrap().0;
    assert_eq!(scene.origin(), [1_234_567.891, 0.0, 0.0], "the origin");
}
