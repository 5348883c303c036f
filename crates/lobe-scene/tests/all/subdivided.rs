//! Documents with the vertices of split scenes.

use lobe_scene::{GltfDocument, GltfReader, Mesh, Scene, SceneReadOptions, built_in, read_scene_bytes};
use serde_json::{Value, json};

use crate::common::Gltf;

/// Positions in the file are halved before the node places them, those of the scene after: some roundings of `f32`.
const ROUNDING: f32 = 4e-7;

fn open(file: &Gltf) -> (Scene, GltfDocument) {
    let reader = GltfReader::open_bytes(&file.glb(), "file.glb", &SceneReadOptions::default()).unwrap();
    let (scene, _, document) = reader.into_scene_and_document().unwrap();
    (scene, document)
}

/// The file with the vertices of meshes of a split scene that come from these meshes of the file.
fn subdivided(document: GltfDocument, split: &[(usize, &Mesh)]) -> Gltf {
    let split: Vec<_> = split.iter().map(|&(mesh, split)| ([mesh, 0], split)).collect();
    let GltfDocument { json, bytes } = document.subdivided(&split).unwrap();
    Gltf { json, buffer: bytes }
}

fn again(file: &Gltf) -> Scene {
    read_scene_bytes(&file.glb(), "again.glb", &SceneReadOptions::default()).unwrap().0
}

/// The numbers of an attribute of a primitive, of the first vertex on.
fn numbers(file: &Gltf, set: &Value, name: &str) -> Vec<f64> {
    let accessor = &file.json["accessors"][set[name].as_u64().unwrap() as usize];
    let view = &file.json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let number = |of: &Value, member: &str| of[member].as_u64().unwrap_or(0) as usize;
    let size = match accessor["type"].as_str().unwrap() {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        _ => 4,
    };
    let (bytes, start) = (&file.buffer, number(view, "byteOffset") + number(accessor, "byteOffset"));
    let width = match number(accessor, "componentType") {
        5120 | 5121 => 1,
        5122 | 5123 => 2,
        _ => 4,
    };
    let stride = number(view, "byteStride").max(if view["byteStride"].is_null() { size * width } else { 0 });
    let read = |at: usize| match number(accessor, "componentType") {
        5120 => f64::from(bytes[at] as i8),
        5121 => f64::from(bytes[at]),
        5123 => f64::from(u16::from_le_bytes([bytes[at], bytes[at + 1]])),
        5125 => f64::from(u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())),
        5126 => f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())),
        other => panic!("components of type {other}"),
    };
    let rows = 0..number(accessor, "count");
    rows.flat_map(|row| (0..size).map(move |k| start + row * stride + k * width)).map(read).collect()
}

/// Fails unless both are the same except for rounding, with the same triangles in the same order. `turn` is how far
/// normals may be turned.
fn assert_alike(found: &Scene, expected: &Scene, turn: f32) {
    assert_eq!(found.meshes().len(), expected.meshes().len(), "meshes");
    for (found, expected) in found.meshes().iter().zip(expected.meshes()) {
        let name = expected.name();
        assert_eq!(found.triangles(), expected.triangles(), "triangles of {name}");
        assert_eq!((found.uvs(0), found.colors()), (expected.uvs(0), expected.colors()), "uvs and colors of {name}");
        let pairs = |a: &[[f32; 3]], b: &[[f32; 3]], slack: f32, what: &str| {
            assert_eq!(a.len(), b.len(), "{what} of {name}");
            for (a, b) in a.as_flattened().iter().zip(b.as_flattened()) {
                assert!((a - b).abs() <= slack * b.abs().max(1.0), "{what} of {name}: {a}, expected {b}");
            }
        };
        pairs(found.positions(), expected.positions(), ROUNDING, "positions");
        pairs(found.normals(), expected.normals(), ROUNDING + turn, "normals");
    }
}

#[test]
fn the_split_scene_is_read_from_the_file_again_whichever_way_it_was_split() {
    for scene in [built_in::cornell_box(8), built_in::ball_over_ground(8), built_in::still_life(16)] {
        let GltfDocument { json, bytes } = GltfDocument::of_scene(&scene);
        let (scene, document) = open(&Gltf { json, buffer: bytes });
        let long = scene.split_edges(0.4).unwrap();
        let rounds = (0..3).fold(long.clone(), |scene, round| {
            scene.halve_edges(|mesh, [a, b]| (mesh as u32 + a + b) % 5 == round).unwrap().0
        });
        // A round of halving makes unit vectors of the normals, between which the next one interpolates.
        for (split, turn) in [(long, 0.0), (rounds, 0.05)] {
            assert!(split.vertex_count() > scene.vertex_count(), "{} vertices", split.vertex_count());
            let all: Vec<_> = split.meshes().iter().enumerate().collect();
            assert_alike(&again(&subdivided(document.clone(), &all)), &split, turn);
        }
    }
}

#[test]
fn triangles_under_a_mirror_keep_the_orientation_of_the_file() {
    let file = Gltf::square().with("/nodes/0/scale", json!([-2.0, 1.0, 1.0]));
    let (scene, document) = open(&file);
    let split = scene.split_edges(0.3).unwrap();
    assert_alike(&again(&subdivided(document, &[(0, &split.meshes()[0])])), &split, 0.0);
}

#[test]
fn others_that_share_what_was_split_keep_it_as_it_was() {
    let mut file = Gltf::square().with_second_square().with("/meshes/1", json!(null));
    file.json["meshes"][1] = file.json["meshes"][0].clone();
    file.json["nodes"][1] = json!({"mesh": 1, "translation": [3.0, 0.0, 0.0]});
    let (scene, document) = open(&file);
    let split = scene.halve_edges(|mesh, _| mesh == 1).unwrap().0;
    let found = again(&subdivided(document, &[(1, &split.meshes()[1])]));
    assert_eq!(found.meshes()[0].positions(), scene.meshes()[0].positions(), "the other");
    assert_eq!(found.meshes()[0].triangles(), scene.meshes()[0].triangles(), "the other");
    assert_alike(&found, &split, 0.0);
}

#[test]
fn quantized_positions_become_floats_so_that_middles_are_not_rounded() {
    let mut file = Gltf::square().with("/extensionsUsed", json!(["KHR_mesh_quantization"]));
    let corners = [[0_i16, 0, 0, 7], [1, 0, 0, 7], [1, 1, 0, 7], [0, 1, 0, 7]];
    let bytes: Vec<u8> = corners.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    // Rows of three numbers, eight bytes apart.
    let whole = file.push("VEC3", 5122, 4, &bytes);
    let view = file.json["accessors"][whole]["bufferView"].as_u64().unwrap() as usize;
    file.json["bufferViews"][view]["byteStride"] = json!(8);
    file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(whole);
    let (scene, document) = open(&file);
    let split = scene.split_edges(0.3).unwrap();
    let found = subdivided(document, &[(0, &split.meshes()[0])]);
    assert_alike(&again(&found), &split, 0.0);
    let positions = numbers(&found, &found.json["meshes"][0]["primitives"][0]["attributes"], "POSITION");
    assert!(positions.contains(&0.25), "{positions:?} has quarters");
}

/// A square with an attribute of each kind.
fn of_all_kinds() -> Gltf {
    let mut file = Gltf::square();
    let uvs = [0_u16, 0, 65535, 0, 65535, 65535, 0, 65535];
    let fine = [0.0_f32, 0.0, 4.0, 0.0, 4.0, 4.0, 0.0, 4.0];
    let colors = [[0, 0, 0, 255], [100, 0, 0, 255], [101, 0, 0, 255], [0, 7, 0, 255]];
    let tangents = [1.0, 0.0, 0.0, -1.0].repeat(4);
    let set = [
        ("NORMAL", file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4))),
        ("TANGENT", file.floats("VEC4", &tangents)),
        ("TEXCOORD_0", file.push("VEC2", 5123, 4, &uvs.map(u16::to_le_bytes).concat())),
        ("TEXCOORD_2", file.push("VEC2", 5126, 4, &fine.map(f32::to_le_bytes).concat())),
        ("COLOR_0", file.push("VEC4", 5121, 4, &colors.concat())),
        ("_HEAT", file.floats("SCALAR", &[0.0, 1.0, 2.0, 3.0])),
        ("_FEATURE_ID_0", file.floats("SCALAR", &[5.0, 6.0, 7.0, 8.0])),
    ];
    for (name, accessor) in set {
        file.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
        if matches!(name, "TEXCOORD_0" | "COLOR_0") {
            file.json["accessors"][accessor]["normalized"] = json!(true);
        }
    }
    // A morph target, all zeros but for one vertex.
    let moved = file.floats("VEC3", &[0.0, 0.0, 8.0]);
    let at = file.push("SCALAR", 5123, 1, &2_u16.to_le_bytes());
    let view = |file: &Gltf, accessor: usize| file.json["accessors"][accessor]["bufferView"].clone();
    let (indices, values) = (view(&file, at), view(&file, moved));
    let indices = json!({"bufferView": indices, "componentType": 5123});
    let sparse = json!({"count": 1, "indices": indices, "values": {"bufferView": values}});
    let accessors = file.json["accessors"].as_array_mut().unwrap();
    accessors.push(json!({"componentType": 5126, "count": 4, "type": "VEC3", "sparse": sparse}));
    let target = accessors.len() - 1;
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": target}]);
    file
}

#[test]
fn attributes_of_every_kind_are_interpolated_names_are_taken_over_and_the_rest_of_the_file_stays() {
    let mut file = of_all_kinds();
    file.json["meshes"][0]["primitives"][0]["extras"] = json!({"a": 1});
    file.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]);
    let (scene, document) = open(&file);
    // The diagonal from 0 to 2, twice: vertices 4 in the middle, 5 to 8 around it.
    let once = scene.halve_edges(|_, edge| edge == [2, 0] || edge == [0, 2]).unwrap().0;
    assert_eq!(once.meshes()[0].halved(), [[2, 0]], "one middle");
    let split = once.halve_edges(|_, _| true).unwrap().0;
    let mesh = &split.meshes()[0];
    let found = subdivided(document, &[(0, mesh)]);
    let primitive = &found.json["meshes"][0]["primitives"][0];
    let set = &primitive["attributes"];
    for name in ["POSITION", "TEXCOORD_0", "TEXCOORD_2", "_HEAT", "COLOR_0"] {
        let values = numbers(&found, set, name);
        let size = values.len() / mesh.positions().len();
        for (k, ends) in mesh.halved().iter().enumerate() {
            for c in 0..size {
                let [p, q, middle] = [ends[0], ends[1], 4 + k as u32].map(|i| values[i as usize * size + c]);
                // Whole numbers are rounded, and so are the ends that were middles.
                let slack = if matches!(name, "COLOR_0" | "TEXCOORD_0") { 1.0 } else { 1e-6 };
                assert!((middle - 0.5 * (p + q)).abs() <= slack, "{name} of {k}: {middle} between {p} and {q}");
            }
        }
    }
    let colors = numbers(&found, set, "COLOR_0");
    assert_eq!(colors[16..20], [51.0, 0.0, 0.0, 255.0], "half of 101, rounded");
    assert_eq!(numbers(&found, set, "NORMAL"), [0.0, 0.0, 1.0].repeat(mesh.positions().len()), "normals");
    assert_eq!(numbers(&found, set, "TANGENT"), [1.0, 0.0, 0.0, -1.0].repeat(mesh.positions().len()), "tangents");
    let ids = numbers(&found, set, "_FEATURE_ID_0");
    assert!(ids.iter().all(|id| (5.0..=8.0).contains(id) && id.fract() == 0.0), "{ids:?} are features");
    let moved = numbers(&found, &primitive["targets"][0], "POSITION");
    assert_eq!((moved[8], moved[14]), (8.0, 4.0), "the morph target, halfway between 8 and 0");
    assert_eq!(primitive["extras"], json!({"a": 1}), "extras");
    assert_eq!(found.json["cameras"], file.json["cameras"], "cameras");
    let bounds = &found.json["accessors"][set["POSITION"].as_u64().unwrap() as usize];
    assert_eq!((&bounds["min"], &bounds["max"]), (&json!([0.0, 0.0, 0.0]), &json!([1.0, 1.0, 0.0])), "bounds");
}

#[test]
fn skins_go_on_to_move_what_was_split() {
    let file = Gltf::skinned();
    let (scene, document) = open(&file);
    let split = scene.split_edges(0.4).unwrap();
    let mesh = &split.meshes()[0];
    let found = subdivided(document, &[(0, mesh)]);
    let set = &found.json["meshes"][0]["primitives"][0]["attributes"];
    let (joints, weights) = (numbers(&found, set, "JOINTS_0"), numbers(&found, set, "WEIGHTS_0"));
    let of = |vertex: usize, joint: f64| -> f64 {
        let all = joints.iter().zip(&weights).skip(4 * vertex).take(4);
        all.filter(|(j, _)| **j == joint).map(|(_, weight)| weight).sum()
    };
    for (k, [p, q]) in mesh.halved().iter().enumerate() {
        for joint in [0.0, 1.0] {
            let expected = 0.5 * (of(*p as usize, joint) + of(*q as usize, joint));
            let weight = of(4 + k, joint);
            assert!((weight - expected).abs() < 1e-6, "joint {joint} of {k}: {weight}, expected {expected}");
        }
    }
}

#[test]
fn meshes_that_are_not_of_the_document_are_refused() {
    let (scene, document) = open(&Gltf::square());
    let other = built_in::ball_over_ground(8).split_edges(0.5).unwrap();
    let refusal =
        |place: [usize; 2], mesh: &Mesh| document.clone().subdivided(&[(place, mesh)]).unwrap_err().to_string();
    let found = refusal([0, 0], &other.meshes()[1]);
    let expected = "the document: mesh `square`, primitive 0: expected a mesh of this primitive whose edges were \
        halved, found another";
    assert_eq!(found, expected, "another mesh");
    assert_eq!(refusal([0, 3], &scene.meshes()[0]), "the document: mesh 0 has no primitive 3", "no primitive");
}
