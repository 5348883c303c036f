//! The finish of surfaces of glTF files: metallic, roughness, occlusion and emission, by numbers and by textures.

use lobe_scene::{Finish, Hit, Scene, SceneError, SceneReadOptions, SceneReadReport, Texture, Wrap, read_scene_bytes};
use serde_json::{Value, json};

use crate::common::{Gltf, base64};

/// The stored parts of a texel: red occlusion, green roughness, blue metallic; as a color, emission.
const TEXEL: [u8; 4] = [51, 102, 204, 255];

/// The square of the tests with a material whose textures all are one of [`TEXEL`].
fn square(material: &Value) -> Gltf {
    let png = Texture::new(1, 1, vec![TEXEL], [Wrap::Repeat; 2]).to_png();
    Gltf::square()
        .with_attribute("TEXCOORD_0", "VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        .with("/meshes/0/primitives/0/material", json!(0))
        .with("/materials", json!([material]))
        .with("/textures", json!([{"source": 0}]))
        .with("/images", json!([{"uri": format!("data:image/png;base64,{}", base64(&png))}]))
}

fn textured() -> Value {
    json!({
        "name": "full",
        "pbrMetallicRoughness": {
            "metallicFactor": 0.5, "roughnessFactor": 0.5, "metallicRoughnessTexture": {"index": 0}
        },
        "occlusionTexture": {"index": 0, "strength": 0.5},
        "emissiveFactor": [1.0, 0.5, 0.25],
        "emissiveTexture": {"index": 0},
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8.0}},
    })
}

fn read_by(file: &Gltf, options: &SceneReadOptions) -> Result<(Scene, SceneReadReport), SceneError> {
    read_scene_bytes(&file.glb(), "a.glb", options)
}

fn finish(scene: &Scene) -> Finish {
    scene.finish(&Hit { t: 1.0, triangle: 0, u: 0.25, v: 0.25 })
}

#[test]
fn green_is_roughness_blue_is_metallic_red_is_occlusion_and_emission_is_a_color() {
    let (scene, report) = read_by(&square(&textured()), &SceneReadOptions::default().finish(true)).unwrap();
    let found = finish(&scene);
    let linear = |c: u8| ((f64::from(c) / 255.0 + 0.055) / 1.055).powf(2.4) as f32;
    let expected = Finish {
        metallic: 0.5 * 0.8,
        roughness: 0.5 * 0.4,
        occlusion: 1.0 + 0.5 * (0.2 - 1.0),
        emission: [8.0 * linear(51), 4.0 * linear(102), 2.0 * linear(204)],
    };
    let numbers = |f: Finish| [f.metallic, f.roughness, f.occlusion, f.emission[0], f.emission[1], f.emission[2]];
    for (found, expected) in numbers(found).into_iter().zip(numbers(expected)) {
        assert!((found - expected).abs() < 1e-6, "{found}, expected {expected}");
    }
    assert!(report.notes.is_empty() && scene.is_emissive() && scene.has_metals(), "{:?}", report.notes);
}

#[test]
fn without_its_textures_a_finish_has_the_numbers_of_the_material_and_notes_say_what_is_left_out() {
    let (scene, report) = read_by(&square(&textured()), &SceneReadOptions::default()).unwrap();
    let expected = Finish { metallic: 0.5, roughness: 0.5, occlusion: 1.0, emission: [8.0, 4.0, 2.0] };
    assert_eq!(finish(&scene), expected, "the factors");
    assert!(scene.textures().is_empty(), "no texture is kept");
    for part in ["emissive, which is not used", "metallic-roughness texture, which is not used"] {
        assert!(report.notes.iter().any(|note| note.contains(part)), "{part}: {:?}", report.notes);
    }
}

#[test]
fn one_roughness_for_all_leaves_the_metallic_of_the_texture() {
    let (scene, _) = read_by(&square(&textured()), &SceneReadOptions::default().finish(true)).unwrap();
    let found = finish(&scene.clone().with_finish(Some(0.75), None).unwrap());
    assert_eq!((found.roughness, found.metallic), (0.75, finish(&scene).metallic), "one roughness");
    let found = finish(&scene.with_finish(None, Some(1.0)).unwrap());
    assert!((found.metallic, found.roughness) == (1.0, 0.5 * 102.0 / 255.0), "{found:?}");
}

#[test]
fn a_finish_of_a_mesh_without_texture_coordinates_is_that_of_the_numbers() {
    let mut bare = square(&textured());
    let attributes = bare.json.pointer_mut("/meshes/0/primitives/0/attributes").unwrap();
    attributes.as_object_mut().unwrap().remove("TEXCOORD_0");
    let (scene, _) = read_by(&bare, &SceneReadOptions::default().finish(true)).unwrap();
    assert_eq!((finish(&scene).metallic, finish(&scene).roughness), (0.5, 0.5), "the factors");
}

#[test]
fn a_finish_that_cannot_be_is_refused_in_one_line() {
    let far = square(&textured()).with("/materials/0/occlusionTexture/index", json!(7));
    let error = read_by(&far, &SceneReadOptions::default().finish(true)).unwrap_err().to_string();
    assert!(error.contains("uses texture 7, but there are 1") && !error.contains('\n'), "{error}");
    let odd =
        square(&textured()).with("/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength", json!(-1));
    let (scene, report) = read_by(&odd, &SceneReadOptions::default().finish(true)).unwrap();
    let note = report.notes.iter().find(|note| note.contains("emissive strength of -1, which is not used"));
    assert!(note.is_some() && finish(&scene).emission[0] > 0.0, "{:?}", report.notes);
}
