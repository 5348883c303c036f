//! Pictures of materials: those that are cut off, missing or of materials that nothing has, and their filters.

use std::fs;

use lobe_scene::{
    Material, Mesh, MeshParts, Scene, SceneError, SceneReadOptions, Texture, TextureUse, Wrap, read_scene,
    read_scene_bytes,
};
use serde_json::{Value, json};

use crate::common::{Gltf, base64};

const JPEG: &[u8] = include_bytes!("../../../lobe-image/tests/data/color.jpg");

fn picture(image: &Value) -> Gltf {
    let material = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    Gltf::square()
        .with("/meshes/0/primitives/0/material", json!(0))
        .with("/materials", json!([material]))
        .with("/textures", json!([{"source": 0}]))
        .with("/images", json!([image]))
}

fn jpeg(bytes: &[u8]) -> Gltf {
    picture(&json!({"uri": format!("data:image/jpeg;base64,{}", base64(bytes))}))
}

#[test]
fn a_photograph_that_is_cut_off_is_refused_in_gltf_and_left_out_of_an_obj() {
    let read = |file: &Gltf| read_scene_bytes(&file.glb(), "a.glb", &SceneReadOptions::default());
    assert_eq!(read(&jpeg(JPEG)).unwrap().0.textures().len(), 1, "all of it");
    let cut = &JPEG[..JPEG.len() - 20];
    let error = read(&jpeg(cut)).map(|_| ()).unwrap_err();
    let expected = "a.glb: image 0: expected a PNG, JPEG, WebP or KTX2, found a JPEG whose end is missing";
    assert_eq!(error.to_string(), expected, "message");
    assert!(matches!(error, SceneError::Invalid { .. }), "{error:?}");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    fs::write(&path, "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl a\nf 1 2 3\n").unwrap();
    fs::write(folder.path().join("a.mtl"), "newmtl a\nKd 0.5\nmap_Kd a.jpg\n").unwrap();
    fs::write(folder.path().join("a.jpg"), cut).unwrap();
    let (scene, report) = read_scene(&path, &SceneReadOptions::default()).unwrap();
    assert_eq!((scene.textures().len(), scene.vertex_base_color(0, 0)), (0, [0.5, 0.5, 0.5, 1.0]), "the color alone");
    assert!(report.notes[0].ends_with("found a JPEG whose end is missing"), "{:?}", report.notes);
}

#[test]
fn pictures_of_materials_that_nothing_has_need_not_be_there() {
    let read = |file: &Gltf| read_scene_bytes(&file.glb(), "a.glb", &SceneReadOptions::default());
    let missing = picture(&json!({"name": "lost"}));
    assert!(read(&missing).is_err(), "it is used");
    let without = Gltf { json: missing.json.clone(), buffer: missing.buffer.clone() };
    let (scene, report) = read(&without.with("/meshes/0/primitives/0/material", json!(null))).unwrap();
    assert_eq!((scene.materials().len(), scene.textures().len()), (1, 0), "materials keep their places");
    assert_eq!(report.notes, Vec::<String>::new(), "notes");
    // A mesh of which no node of the scene is.
    let elsewhere = json!({"primitives": [missing.json["meshes"][0]["primitives"][0].clone()]});
    let file = Gltf { json: missing.json.clone(), buffer: missing.buffer.clone() };
    let file = file.with("/meshes/0/primitives/0/material", json!(null)).with("/meshes/1", elsewhere);
    assert_eq!(read(&file).unwrap().0.textures().len(), 0, "not shown");
    assert!(read(&file.with("/nodes/0/mesh", json!(1))).is_err(), "shown");
}

#[test]
fn a_filter_that_is_not_used_is_noted_once() {
    let png = Texture::new(2, 1, vec![[255, 0, 0, 255], [0, 0, 255, 255]], [Wrap::Repeat; 2]).to_png();
    let file = picture(&json!({"uri": format!("data:image/png;base64,{}", base64(&png))}));
    let material = file.json["materials"][0].clone();
    let primitive = file.json["meshes"][0]["primitives"][0].clone();
    let file = file
        .with("/materials/1", material)
        .with("/meshes/0/primitives/1", primitive)
        .with("/meshes/0/primitives/1/material", json!(1))
        .with("/textures/0/sampler", json!(0));
    for (filter, expected) in [(9728, 1), (9729, 0)] {
        let file = Gltf { json: file.json.clone(), buffer: file.buffer.clone() };
        let file = file.with("/samplers", json!([{"magFilter": filter, "minFilter": 9728}]));
        let (_, report) = read_scene_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).unwrap();
        let note = "the filter NEAREST of textures is not used: colors are interpolated between texels";
        assert_eq!(report.notes, vec![note; expected], "filter {filter}");
    }
}

#[test]
fn a_map_of_the_largest_numbers_still_leads_to_texels() {
    for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
        let texture = Texture::new(2, 1, vec![[255; 4], [0; 4]], [wrap; 2]);
        let used = TextureUse { texture: 0, uv_set: 0, uv_map: [[3e38, -3e38, 0.0], [0.0, 3e38, 3e38]] };
        let material = Material { base_color_texture: Some(used), ..Material::WHITE };
        let mut parts = MeshParts {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            material: Some(0),
            ..MeshParts::default()
        };
        parts.uvs[0] = vec![[2.0, 2.0], [2.0, 0.0], [3e38, -3e38]];
        let scene = Scene::new(vec![Mesh::new(parts).unwrap()], vec![material], vec![texture]).unwrap();
        for vertex in 0..3 {
            let color = scene.vertex_base_color(0, vertex);
            assert!(color.iter().all(|c| (0.0..=1.0).contains(c)), "{wrap:?}, vertex {vertex}: {color:?}");
        }
    }
}
