//! Documents without what nothing names.

use lobe_scene::{GltfDocument, GltfReader, Scene, SceneReadOptions, Texture, Wrap, built_in, read_scene_bytes};
use lobe_testkit::glb_unused;
use serde_json::json;

use crate::common::Gltf;

const NOTHING: [&str; 0] = [];

fn open(file: &Gltf) -> (Scene, GltfDocument) {
    let reader = GltfReader::open_bytes(&file.glb(), "file.glb", &SceneReadOptions::default()).unwrap();
    let (scene, _, document) = reader.into_scene_and_document().unwrap();
    (scene, document)
}

fn glb(document: &GltfDocument) -> Vec<u8> {
    Gltf { json: document.json.clone(), buffer: document.bytes.clone() }.glb()
}

fn again(document: &GltfDocument) -> Scene {
    read_scene_bytes(&glb(document), "again.glb", &SceneReadOptions::default()).unwrap().0
}

fn unused(document: &GltfDocument) -> Vec<String> {
    glb_unused(&glb(document))
}

/// The document with the vertices of all meshes of a split scene.
fn subdivided(document: GltfDocument, split: &Scene) -> GltfDocument {
    let split: Vec<_> = split.meshes().iter().enumerate().map(|(mesh, split)| ([mesh, 0], split)).collect();
    document.subdivided(&split).unwrap()
}

#[test]
fn of_a_split_scene_nothing_is_left_that_nothing_names_and_it_is_read_as_before() {
    for scene in [built_in::cornell_box(8), built_in::ball_over_ground(8), built_in::still_life(16)] {
        let GltfDocument { json, bytes } = GltfDocument::of_scene(&scene);
        let (scene, document) = open(&Gltf { json, buffer: bytes });
        let long = subdivided(document, &scene.split_edges(0.4).unwrap());
        assert!(!unused(&long).is_empty(), "the old attributes");
        let pruned = long.clone().pruned();
        assert_eq!(unused(&pruned), NOTHING, "named by nothing");
        assert!(pruned.bytes.len() < long.bytes.len(), "{} bytes of {}", pruned.bytes.len(), long.bytes.len());
        assert_eq!(again(&pruned).meshes(), again(&long).meshes(), "the scene");
        assert_eq!(pruned.clone().pruned(), pruned, "pruned again");
    }
}

#[test]
fn skins_animations_sparse_accessors_and_pictures_keep_their_data() {
    let mut file = Gltf::skinned().with_channel(
        0,
        (2, "translation"),
        "LINEAR",
        (&[0.0, 1.0], "VEC3", &[0.0, 1.0, 0.0, 5.0, 6.0, 7.0]),
    );
    let picture = Texture::new(1, 1, vec![[1, 2, 3, 255]], [Wrap::Repeat; 2]).to_png();
    let of_picture = file.push("SCALAR", 5121, picture.len(), &picture);
    let view = file.json["accessors"].as_array_mut().unwrap().remove(of_picture)["bufferView"].take();
    file.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
    let parts = [file.push("SCALAR", 5123, 1, &[2, 0]), file.floats("VEC3", &[0.0, 0.0, 8.0])];
    let [indices, values] = parts.map(|part| file.json["accessors"][part]["bufferView"].clone());
    let accessors = file.json["accessors"].as_array_mut().unwrap();
    accessors.truncate(parts[0]);
    let indices = json!({"bufferView": indices, "componentType": 5123});
    let sparse = json!({"count": 1, "indices": indices, "values": {"bufferView": values}});
    accessors.push(json!({"componentType": 5126, "count": 4, "type": "VEC3", "sparse": sparse}));
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": parts[0]}]);
    // Nothing is to be taken out, and then something before all of it.
    let (_, document) = open(&file);
    assert_eq!(document.clone().pruned(), document, "all of it is named");
    let mut longer = document.clone();
    let bytes = [&[7; 100], &document.bytes[..]].concat();
    for view in longer.json["bufferViews"].as_array_mut().unwrap() {
        view["byteOffset"] = json!(view["byteOffset"].as_u64().unwrap_or(0) + 100);
    }
    longer.bytes = bytes;
    let pruned = longer.pruned();
    assert_eq!(unused(&pruned), NOTHING, "named by nothing");
    assert!(pruned.bytes.ends_with(&document.bytes), "{} bytes", pruned.bytes.len());
    // The indices of the square are written anew; the old ones stood second.
    let mut renamed = document.clone();
    let array = |json: &mut serde_json::Value, name: &str, item| json[name].as_array_mut().unwrap().push(item);
    let accessor = renamed.json["accessors"][1].clone();
    renamed.json["meshes"][0]["primitives"][0]["indices"] = json!(parts[0] + 1);
    array(&mut renamed.json, "accessors", accessor);
    let pruned = renamed.pruned();
    assert_eq!(unused(&pruned), NOTHING, "named by nothing");
    assert_eq!(pruned.json["skins"][0]["inverseBindMatrices"], 4, "one less: {}", pruned.json["skins"]);
    assert_eq!(again(&pruned).meshes(), again(&document).meshes(), "the scene");
    assert_eq!(pruned.bytes, document.bytes, "the bytes are those of the new accessor");
}

#[test]
fn what_an_unknown_extension_or_extras_may_name_keeps_its_index_and_bytes() {
    for pointer in ["extensions", "extras"] {
        let mut file = Gltf::square().with_attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4));
        let dead: Vec<_> = (0..4).map(|k| file.floats("SCALAR", &[k as f32])).collect();
        let (scene, mut document) = open(&file);
        document.json[pointer] = json!({"EXAMPLE_table": {"rows": [{"values": dead[1]}], "size": 1000}});
        let pruned = document.clone().pruned();
        let kept = dead[1] + 1;
        for array in ["accessors", "bufferViews"] {
            let items = |document: &GltfDocument| document.json[array].as_array().unwrap()[..kept].to_vec();
            assert_eq!(items(&pruned), items(&document), "the first of {array}, {pointer}");
            assert_eq!(pruned.json[array].as_array().map(Vec::len), Some(kept), "{array}, {pointer}");
        }
        assert_eq!(pruned.bytes, document.bytes[..document.bytes.len() - 8], "two numbers of four bytes, {pointer}");
        assert_eq!(again(&pruned).meshes().len(), scene.meshes().len(), "the scene, {pointer}");
        document.json[pointer]["EXAMPLE_table"]["buffer"] = json!(0);
        assert_eq!(document.clone().pruned(), document, "bytes of {pointer} are not known");
    }
}

#[test]
fn views_that_overlap_and_stand_apart_keep_their_bytes_and_alignment() {
    let bytes: Vec<u8> = (0..64).collect();
    let ranges = [(41, 9), (3, 6), (8, 4), (24, 8), (28, 2)];
    let views = ranges.map(|(at, length)| json!({"buffer": 0, "byteOffset": at, "byteLength": length}));
    let images: Vec<_> = (0..5).map(|view| json!({"bufferView": view})).collect();
    let json = json!({"bufferViews": views, "images": images, "buffers": [{"byteLength": 64}]});
    let pruned = GltfDocument { json, bytes: bytes.clone() }.pruned();
    for (view, (at, length)) in pruned.json["bufferViews"].as_array().unwrap().iter().zip(ranges) {
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        assert_eq!(pruned.bytes[start..start + length], bytes[at..at + length], "{at}, now {start}");
        assert_eq!(start % 8, at % 8, "{at}, now {start}");
    }
    assert_eq!(unused(&pruned), NOTHING, "named by nothing");
    // 3 to 12, 16 to 24 and 25 to 34.
    assert_eq!((pruned.bytes.len(), &pruned.json["buffers"][0]["byteLength"]), (34, &json!(34)), "bytes");
}

#[test]
fn a_document_whose_data_nothing_names_has_none() {
    let (_, mut document) = open(&Gltf::square());
    ["scene", "scenes", "nodes", "meshes"].iter().for_each(|name| document.json[*name] = json!(null));
    let pruned = document.pruned();
    let members = ["accessors", "bufferViews", "buffers"].map(|name| pruned.json.get(name).cloned());
    assert_eq!((members, pruned.bytes.len()), ([None, None, None], 0), "{}", pruned.json);
}
