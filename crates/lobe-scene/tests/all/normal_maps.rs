//! Normal textures of glTF files: the normals that surfaces get from them, and what is said where they get none.

use std::f64::consts::FRAC_PI_2;
use std::fs;

use lobe_scene::{
    AnimatedScene, GltfDocument, Hit, Mesh, Scene, SceneError, SceneReadOption, SceneReadOptions, SceneReadReport,
    Texture, Wrap, read_scene, read_scene_bytes,
};
use serde_json::{Value, json};

use crate::common::{Gltf, base64};

/// A texel that tilts to the right and, less, up.
const TEXEL: [u8; 4] = [220, 160, 200, 255];

/// What it stands for.
fn tilt() -> [f64; 3] {
    unit([0, 1, 2].map(|k| 2.0 * f64::from(TEXEL[k]) / 255.0 - 1.0))
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    v.map(|c| c / length)
}

fn uri(texels: &[[u8; 4]]) -> Value {
    let png = Texture::new(texels.len(), 1, texels.to_vec(), [Wrap::Repeat; 2]).to_png();
    json!(format!("data:image/png;base64,{}", base64(&png)))
}

/// The square in the plane z = 0 of its y-up file, its pictures upright, with a normal texture of these texels.
fn mapped(texels: &[[u8; 4]]) -> Gltf {
    Gltf::square()
        .with_attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4))
        .with_attribute("TEXCOORD_0", "VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        .with("/meshes/0/primitives/0/material", json!(0))
        .with("/materials", json!([{"name": "bumpy", "normalTexture": {"index": 0}}]))
        .with("/textures", json!([{"source": 0}]))
        .with("/images", json!([{"uri": uri(texels)}]))
}

fn read_by(file: &Gltf, options: &SceneReadOptions) -> Result<(Scene, SceneReadReport), SceneError> {
    read_scene_bytes(&file.glb(), "a.glb", options)
}

fn read(file: &Gltf) -> Scene {
    read_by(file, &SceneReadOptions::default()).unwrap().0
}

/// The shading normal of both triangles of a scene in their middle, in the y-up frame of its file.
fn normals(scene: &Scene) -> [[f64; 3]; 2] {
    [0, 1].map(|triangle| {
        let hit = Hit { t: 1.0, triangle, u: 0.25, v: 0.25 };
        let [x, y, z] = scene.surface(&hit).shading_normal.map(f64::from);
        [x, z, -y]
    })
}

fn assert_normals(scene: &Scene, expected: [f64; 3], what: &str) {
    for found in normals(scene) {
        let off = (0..3).map(|k| (found[k] - expected[k]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{what}: {found:?}, expected {expected:?}");
    }
}

#[test]
fn the_normal_texture_of_a_file_tilts_normals_by_given_and_by_computed_tangents() {
    let [x, y, z] = tilt();
    let given = mapped(&[TEXEL]).with_attribute("TANGENT", "VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(4));
    let turned = mapped(&[TEXEL]).with_attribute("TANGENT", "VEC4", &[0.0, 1.0, 0.0, -1.0].repeat(4));
    let mirror = json!([-1.0, 1.0, 1.0]);
    for (what, file, expected) in [
        ("computed", mapped(&[TEXEL]), [x, y, z]),
        ("given", given, [x, y, z]),
        ("given otherwise", turned, [y, x, z]),
        ("computed, mirrored", mapped(&[TEXEL]).with("/nodes/0/scale", mirror.clone()), [-x, y, z]),
        ("stretched", mapped(&[TEXEL]).with("/nodes/0/scale", json!([3.0, 0.5, 2.0])), [x, y, z]),
    ] {
        let scene = read(&file);
        assert!(scene.has_normal_maps(), "{what}");
        assert_normals(&scene, expected, what);
    }
    // A mirror turns the sign of given tangents around.
    let given = mapped(&[TEXEL]).with_attribute("TANGENT", "VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(4));
    assert_normals(&read(&given.with("/nodes/0/scale", mirror)), [-x, y, z], "given, mirrored");
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

#[test]
fn given_tangents_follow_nodes_that_shear_or_stretch_as_what_they_run_along() {
    let [x, y, z] = tilt();
    // By columns.
    let shear = [[1.0, 0.0, 0.0], [0.5, 1.0, 0.4], [0.3, 0.0, 1.0]];
    let along_a_diagonal = [[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 1.0]];
    for [a, b, c] in [shear, along_a_diagonal] {
        let mut columns = [a, b, c].map(|[x, y, z]| [x, y, z, 0.0]).to_vec();
        columns.push([0.0, 0.0, 0.0, 1.0]);
        let given = mapped(&[TEXEL]).with_attribute("TANGENT", "VEC4", &[0.6, 0.8, 0.0, 1.0].repeat(4));
        let (n, t) = (unit(cross(a, b)), unit([0, 1, 2].map(|k| 0.6 * a[k] + 0.8 * b[k])));
        let side = cross(n, t);
        let expected = [0, 1, 2].map(|k| x * t[k] + y * side[k] + z * n[k]);
        assert_normals(
            &read(&given.with("/nodes/0/matrix", json!(columns.as_flattened()))),
            expected,
            "a node's matrix",
        );
    }
}

/// The uv of the square's corners.
const CORNERS: [[f64; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];

#[test]
fn a_picture_that_is_turned_or_mirrored_in_the_texture_coordinates_tilts_along_its_own_axes() {
    let [x, y, z] = tilt();
    let transformed = |file: Gltf, rotation: f64, scale: [f64; 2]| {
        let transform = json!({"KHR_texture_transform": {"rotation": rotation, "scale": scale}});
        file.with("/materials/0/normalTexture", json!({"index": 0, "extensions": transform}))
    };
    let given = || mapped(&[TEXEL]).with_attribute("TANGENT", "VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(4));
    // A quarter turn takes the u of the picture against y of the file and its v against x.
    for (rotation, scale, expected) in
        [(FRAC_PI_2, [1.0, 1.0], [y, -x, z]), (0.0, [-1.0, 1.0], [-x, y, z]), (0.0, [1.0, -1.0], [x, -y, z])]
    {
        for (what, file) in [("computed", mapped(&[TEXEL])), ("given", given())] {
            assert_normals(
                &read(&transformed(file, rotation, scale)),
                expected,
                &format!("{what}, {rotation}, {scale:?}"),
            );
        }
    }
    // The same as of texture coordinates that are transformed in the file.
    for (rotation, scale) in [(0.7, [1.0, 1.0]), (-2.0, [-1.5, 0.5]), (1.0, [-2.0, -3.0])] {
        let (sin, cos) = f64::sin_cos(rotation);
        let place = |[u, v]: [f64; 2]| {
            let (u, v) = (scale[0] * u, scale[1] * v);
            [(cos * u + sin * v) as f32, (cos * v - sin * u) as f32]
        };
        let uvs = CORNERS.map(place);
        let plain = mapped(&[TEXEL]).with_attribute("TEXCOORD_0", "VEC2", uvs.as_flattened());
        let [expected, _] = normals(&read(&plain));
        for (what, file) in [("computed", mapped(&[TEXEL])), ("given", given())] {
            assert_normals(
                &read(&transformed(file, rotation, scale)),
                expected,
                &format!("{what}, {rotation}, {scale:?}"),
            );
        }
    }
}

#[test]
fn tangents_of_a_file_without_normals_are_left_out_as_gltf_says() {
    let [x, y, z] = tilt();
    let mut file = mapped(&[TEXEL]).with_attribute("TANGENT", "VEC4", &[0.0, 1.0, 0.0, -1.0].repeat(4));
    file.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("NORMAL");
    assert_normals(&read(&file), [x, y, z], "computed");
}

#[test]
fn scale_set_and_transform_of_the_texture_count() {
    let [x, y, z] = tilt().map(|c| c / tilt()[2]);
    let flat = [128, 128, 255, 255];
    let at = |texture: Value| mapped(&[TEXEL, flat]).with("/materials/0/normalTexture", texture);
    let transform = |offset: f64| json!({"KHR_texture_transform": {"offset": [offset, 0.0], "scale": [0.0, 0.0]}});
    let half = at(json!({"index": 0, "scale": 0.5, "extensions": transform(0.25)}));
    assert_normals(&read(&half), unit([0.5 * x, 0.5 * y, z]), "half as steep, at the first texel");
    let none = at(json!({"index": 0, "scale": 0.0, "extensions": transform(0.25)}));
    assert_normals(&read(&none), [0.0, 0.0, 1.0], "scale 0");
    let small = f64::from(128_u8) * 2.0 / 255.0 - 1.0;
    let second = at(json!({"index": 0, "extensions": transform(0.75)}));
    assert_normals(&read(&second), unit([small, small, 1.0]), "at the second texel");
    // The second set turns the picture by a quarter: its u runs against y of the file, its v against x.
    let turned = mapped(&[TEXEL]).with_attribute("TEXCOORD_1", "VEC2", &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let turned = turned.with("/materials/0/normalTexture", json!({"index": 0, "texCoord": 1}));
    assert_normals(&read(&turned), unit([y, -x, z]), "by the second set");
}

#[test]
fn normal_textures_that_cannot_be_read_are_refused_in_one_line() {
    let refusal = |file: &Gltf| read_by(file, &SceneReadOptions::default()).map(|_| ()).unwrap_err().to_string();
    let with = |texture: Value| mapped(&[TEXEL]).with("/materials/0/normalTexture", texture);
    let three = mapped(&[TEXEL]).with_attribute("TANGENT", "VEC4", &[1.0; 16]);
    let accessors = three.json["accessors"].as_array().unwrap().len();
    for (file, expected) in [
        (with(json!({"index": 3})), "a.glb: material `bumpy` uses texture 3, but there are 1"),
        (
            mapped(&[TEXEL]).with("/images/0/uri", json!("data:image/png;base64,AAAA")),
            "a.glb: image 0: expected a PNG, JPEG, WebP or KTX2, found another kind of file",
        ),
        (
            with(json!({"index": 0, "extensions": {"KHR_texture_transform": {"rotation": "much"}}})),
            "a.glb: material `bumpy`: expected a normal texture, found an error: invalid type",
        ),
        (
            with(json!({"index": 0, "scale": 1e39})),
            "a.glb: scene: material `bumpy`: expected a finite scale of its normal map, found inf",
        ),
        (
            three.with(&format!("/accessors/{}/count", accessors - 1), json!(3)),
            "a.glb: mesh `square`, primitive 0: expected 4 tangents, one for each vertex, found 3",
        ),
        (
            mapped(&[TEXEL]).with_attribute("TANGENT", "VEC3", &[1.0; 12]),
            "a.glb: mesh `square`, primitive 0: expected vectors of 4 floats as TANGENT, found 3 x F32",
        ),
    ] {
        let found = refusal(&file);
        assert!(found.starts_with(expected) && !found.contains('\n'), "{found}, expected {expected}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    fs::write(&path, mapped(&[TEXEL]).with("/images/0/uri", json!("lost.png")).glb()).unwrap();
    let error = read_scene(&path, &SceneReadOptions::default()).map(|_| ()).unwrap_err();
    assert!(matches!(error, SceneError::Io { .. }) && error.to_string().contains("lost.png, named by"), "{error}");
}

#[test]
fn where_normal_textures_are_not_used_a_note_says_so() {
    let mut bare = mapped(&[TEXEL]);
    bare.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    let (scene, report) = read_by(&bare, &SceneReadOptions::default()).unwrap();
    assert!(!scene.has_normal_maps() && scene.meshes()[0].tangents().is_empty(), "no texture coordinates");
    let note = "mesh `square` has no texture coordinates of set 0 for the normal texture of its material, which is not used there";
    assert_eq!(report.notes, [note], "no texture coordinates");
    assert_normals(&scene, [0.0, 0.0, 1.0], "no texture coordinates");

    let note = "material `bumpy` has a normal texture, which is not used";
    let (scene, report) = read_by(&mapped(&[TEXEL]), &SceneReadOptions::default().normal_maps(false)).unwrap();
    assert_eq!((report.notes, scene.textures().len()), (vec![note.to_owned()], 0), "not wanted");
    let (moving, report) =
        AnimatedScene::read_bytes(&mapped(&[TEXEL]).glb(), "a.glb", &SceneReadOptions::default()).unwrap();
    assert_eq!((report.notes, moving.rest().textures().len()), (vec![note.to_owned()], 0), "scenes that move");
    let still = AnimatedScene::still(read(&mapped(&[TEXEL])));
    assert!(
        !still.rest().has_normal_maps() && !still.rest_pose().unwrap().scene().has_normal_maps(),
        "one that stands"
    );
    let (_, report) = read_by(&mapped(&[TEXEL]), &SceneReadOptions::default()).unwrap();
    assert_eq!(report.notes, Vec::<String>::new(), "where they are used");
}

#[test]
fn texels_and_tangents_count_against_the_limits() {
    let file = mapped(&[TEXEL; 5]);
    let texels = |most| read_by(&file, &SceneReadOptions::default().max_texels(most)).map(|_| ());
    assert!(texels(5).is_ok(), "five texels");
    let refused = texels(4);
    assert!(matches!(refused, Err(SceneError::Refused { option: SceneReadOption::MaxTexels, .. })), "{refused:?}");
    // The least bytes that suffice, by bisection.
    let least = |normal_maps: bool| {
        let (mut low, mut high) = (0, 1 << 20);
        while low + 1 < high {
            let middle = (low + high) / 2;
            let options = SceneReadOptions::default().normal_maps(normal_maps).max_bytes(middle);
            if read_by(&file, &options).is_ok() { high = middle } else { low = middle }
        }
        high
    };
    let (with, without) = (least(true), least(false));
    assert!(with >= without + 5 * 4 + 2 * 48, "{with} bytes with a normal map, {without} without");
}

#[test]
fn a_scene_with_normal_maps_comes_back_from_the_file_that_it_is_written_to() {
    let again = |scene: &Scene| {
        let GltfDocument { json, bytes } = GltfDocument::of_scene(scene);
        let has_tangents = json["meshes"][0]["primitives"][0]["attributes"].get("TANGENT").is_some();
        (read(&Gltf { json, buffer: bytes }), has_tangents)
    };
    let scene = read(&mapped(&[TEXEL, [10, 200, 220, 255]]));
    let (found, has_tangents) = again(&scene);
    assert_eq!(found.materials(), scene.materials(), "materials");
    assert_eq!((found.textures(), found.meshes()), (scene.textures(), scene.meshes()), "textures and meshes");
    assert!(has_tangents, "one tangent for each vertex");
    // Of a vertex with two tangents none is written: they are computed again, from the same texture coordinates.
    let (meshes, materials, textures) = scene.clone().into_parts();
    let mut parts = meshes[0].clone().into_parts();
    parts.tangents[1] = [[0.0, 0.0, 1.0, 1.0]; 3];
    let other = Scene::new(vec![Mesh::new(parts).unwrap()], materials, textures).unwrap();
    let (found, has_tangents) = again(&other);
    assert!(!has_tangents && found.meshes() == scene.meshes(), "{:?}", found.meshes()[0].tangents());
}
