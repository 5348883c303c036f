//! Baked .glb files: transfer is read back as written, and nothing of the input is lost.

use std::fs;
use std::path::{Path, PathBuf};

use lobe_io::Job;
use lobe_prt::{
    BakedGlb, BakedOrScene, Channels, CompressOptions, CompressedTransfer, LOBE_EXTRAS_VERSION, PrtError, Recipe,
    Transfer, WeightBits, read_baked, read_baked_bytes, read_baked_or_scene_bytes,
};
use lobe_scene::{
    Alpha, GltfDocument, GltfReader, Material, Mesh, MeshParts, Scene, SceneReadOptions, Texture, TextureUse, Wrap,
    built_in, read_scene,
};
use lobe_testkit::{glb_faults, glb_unused};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Numbers that differ at every place.
fn transfer_of(scene: &Scene, order: usize, channels: Channels) -> Transfer {
    let count = scene.vertex_count() * order * order * channels.count();
    Transfer::new(order, channels, (0..count).map(|i| i as f32 - 0.5).collect()).unwrap()
}

fn scene_of(path: &Path) -> Scene {
    read_scene(path, &SceneReadOptions::default()).unwrap().0
}

/// The output of a bake of a file, without its transfer.
fn glb_of_file(path: &Path) -> BakedGlb {
    let (scene, _, document) =
        GltfReader::open(path, &SceneReadOptions::default()).and_then(GltfReader::into_scene_and_document).unwrap();
    BakedGlb::of_document(document, &scene).unwrap()
}

/// JSON and buffer of a .glb, which is checked by glTF's rules, and for what nothing names.
pub(crate) fn parts_of(path: &Path) -> (Value, Vec<u8>) {
    let bytes = fs::read(path).unwrap();
    assert_eq!(glb_faults(&bytes), Vec::<String>::new(), "faults of {}", path.display());
    assert_eq!(glb_unused(&bytes), Vec::<String>::new(), "what nothing names in {}", path.display());
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let bin = 20 + word(12);
    (serde_json::from_slice(&bytes[20..bin]).unwrap(), bytes[bin + 8..].to_vec())
}

/// A .glb of these parts.
fn glb_of(json: &Value, buffer: &[u8]) -> Vec<u8> {
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let words = |words: &[u32]| words.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>();
    let kinds = [*b"glTF", *b"JSON", *b"BIN\0"].map(u32::from_le_bytes);
    let length = (28 + json.len() + buffer.len()) as u32;
    let header = words(&[kinds[0], 2, length, json.len() as u32, kinds[1]]);
    [header, json, words(&[buffer.len() as u32, kinds[2]]), buffer.to_vec()].concat()
}

/// Writes a .gltf and its buffer beside it.
pub(crate) fn write_gltf(folder: &TempDir, name: &str, json: &Value, bytes: &[u8]) -> PathBuf {
    let mut json = json.clone();
    json["buffers"][0]["byteLength"] = json!(bytes.len());
    json["buffers"][0]["uri"] = json!(format!("{name}%20data.bin"));
    fs::write(folder.path().join(format!("{name} data.bin")), bytes).unwrap();
    let path = folder.path().join(format!("{name}.gltf"));
    fs::write(&path, json.to_string()).unwrap();
    path
}

/// The same vertices, triangles and materials; normals within the rounding of normalizing them once more.
fn assert_same_scene(found: &Scene, expected: &Scene) {
    assert_eq!(found.meshes().len(), expected.meshes().len(), "meshes");
    for (i, (a, b)) in found.meshes().iter().zip(expected.meshes()).enumerate() {
        assert_eq!(a.positions(), b.positions(), "positions of mesh {i}");
        assert_eq!(a.triangles(), b.triangles(), "triangles of mesh {i}");
        assert_eq!((a.uvs(0), a.uvs(1), a.colors()), (b.uvs(0), b.uvs(1), b.colors()), "attributes of mesh {i}");
        for (n, m) in a.normals().as_flattened().iter().zip(b.normals().as_flattened()) {
            assert!((n - m).abs() < 2e-7, "normals of mesh {i}: {n} and {m}");
        }
        let unnamed = |m: &Material| Material { name: String::new(), ..m.clone() };
        assert_eq!(unnamed(found.material(i)), unnamed(expected.material(i)), "material of mesh {i}");
    }
    assert_eq!(found.textures(), expected.textures(), "textures");
}

#[test]
fn built_in_scenes_come_back_with_their_transfer() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("baked.glb");
    for (scene, order, channels) in [
        (built_in::ball_over_ground(16), 4, Channels::Rgb),
        (built_in::columns_hall(1), 3, Channels::Gray),
        (built_in::closed_white_box(2), 1, Channels::Gray),
        (built_in::cornell_box(8).split_edges(0.2).unwrap(), 8, Channels::Rgb),
    ] {
        let transfer = transfer_of(&scene, order, channels);
        let recipe = Recipe::from(json!({"mode": "shadowed", "samples": 1024, "nested": {"a": [1, 2.5]}}));
        let baked = BakedGlb::of_scene(&scene);
        baked.write(&path, &transfer, &recipe, Job::default()).unwrap();
        parts_of(&path);
        let found = read_baked(&path, &SceneReadOptions::default()).unwrap();
        assert_same_scene(&found.scene, &scene);
        assert_eq!(found.transfer, transfer, "order {order}");
        assert_eq!(found.recipe, recipe, "recipe");
        let (size, estimate) = (fs::metadata(&path).unwrap().len(), baked.size(order, channels));
        assert!(estimate <= size && size < estimate + 40_000, "{size} bytes, {estimate} without the JSON");
    }
}

#[test]
fn materials_and_textures_of_a_scene_without_a_gltf_file_come_back() {
    let turned = [[0.0, 2.0, 0.25], [-0.5, 0.0, 0.75]];
    let texture = Texture::new(2, 1, vec![[255, 0, 9, 255], [0, 128, 255, 7]], [Wrap::Mirror, Wrap::Clamp]);
    let used = |uv_set, uv_map| Some(TextureUse { texture: 0, uv_set, uv_map });
    let materials = vec![
        Material {
            base_color: [0.1, 0.2, 0.3, 0.4],
            base_color_texture: used(0, TextureUse::UV_UNCHANGED),
            alpha: Alpha::Mask(0.3),
            double_sided: false,
            metallic: 0.25,
            roughness: 0.75,
            emissive: [0.5, 0.25, 1.0],
            name: "a".into(),
            ..Material::WHITE
        },
        Material { base_color_texture: used(1, [[2.0, 0.0, 0.1], [0.0, -3.0, 0.2]]), ..Material::WHITE },
        Material { base_color_texture: used(1, turned), alpha: Alpha::Blend, ..Material::WHITE },
    ];
    let mesh = |material| {
        Mesh::new(MeshParts {
            positions: vec![[0.0, 0.0, 1.5], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            uvs: [vec![[0.0, 0.5]; 3], vec![[0.25, 0.125]; 3]],
            colors: vec![[1.0, 0.5, 0.25, 1.0]; 3],
            material,
            ..MeshParts::default()
        })
    };
    let meshes = [Some(0), Some(1), Some(2), None].map(|material| mesh(material).unwrap());
    let scene = Scene::new(meshes.to_vec(), materials, vec![texture]).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("baked.glb");
    BakedGlb::of_scene(&scene)
        .write(&path, &transfer_of(&scene, 2, Channels::Rgb), &Recipe::default(), Job::default())
        .unwrap();
    parts_of(&path);
    let found = read_baked(&path, &SceneReadOptions::default()).unwrap().scene;
    let map = found.material(2).base_color_texture.unwrap().uv_map;
    for (found, expected) in map.as_flattened().iter().zip(turned.as_flattened()) {
        assert!((found - expected).abs() < 1e-6, "{map:?}, expected {turned:?}");
    }
    let (meshes, mut materials, textures) = found.into_parts();
    materials[2].base_color_texture = used(1, turned);
    assert_same_scene(&Scene::new(meshes, materials, textures).unwrap(), &scene);
}

/// A file with much that is no part of a scene: a ball that two nodes show, a third outside of the scene, a camera,
/// extras, an extension, a normal texture in a file beside it and one that is missing.
fn rich_file(folder: &TempDir) -> PathBuf {
    let GltfDocument { mut json, bytes } = GltfDocument::of_scene(&built_in::ball_over_ground(8));
    json["asset"]["extras"] = json!({"author": "somebody"});
    json["asset"]["copyright"] = json!("CC0");
    json["nodes"].as_array_mut().unwrap().extend([
        json!({"mesh": 1, "translation": [3.0, 0.5, 0.0], "extras": {"note": "second"}}),
        json!({"mesh": 1, "name": "outside"}),
        json!({"camera": 0}),
    ]);
    json["scenes"][0]["nodes"] = json!([0, 1, 2, 4]);
    json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]);
    json["meshes"][1]["extras"] = json!("a text");
    json["extensionsUsed"] = json!(["XMP_example"]);
    json["extensions"] = json!({"XMP_example": {"a": "b"}});
    let normal_map = Texture::new(1, 1, vec![[128, 128, 255, 255]], [Wrap::Repeat; 2]);
    fs::write(folder.path().join("normal map.png"), normal_map.to_png()).unwrap();
    json["images"] = json!([{"uri": "normal%20map.png", "name": "n"}, {"uri": "missing.png"}]);
    json["textures"] = json!([{"source": 0}, {"source": 1}]);
    json["materials"][0]["normalTexture"] = json!({"index": 0});
    json["materials"][0]["occlusionTexture"] = json!({"index": 1});
    write_gltf(folder, "rich", &json, &bytes)
}

#[test]
fn a_gltf_file_keeps_all_it_has_and_every_node_has_transfer_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let input = rich_file(&folder);
    let scene = scene_of(&input);
    assert_eq!(scene.meshes().len(), 3, "the ground and two balls");
    let transfer = transfer_of(&scene, 3, Channels::Rgb);
    let (_, report, document) =
        GltfReader::open(&input, &SceneReadOptions::default()).and_then(GltfReader::into_scene_and_document).unwrap();
    let baked = BakedGlb::of_document(document, &scene).unwrap();
    let path = folder.path().join("baked.glb");
    baked.write(&path, &transfer, &Recipe::default().seed(7), Job::default()).unwrap();

    let found = read_baked(&path, &SceneReadOptions::default()).unwrap();
    for (a, b) in found.scene.meshes().iter().zip(scene.meshes()) {
        let [a, b] = [a, b].map(|mesh| (mesh.positions(), mesh.normals(), mesh.triangles()));
        assert_eq!(a, b, "bit for bit");
    }
    assert_eq!(found.transfer, transfer, "transfer of all nodes");
    let [extension, outside, unused] = &report.notes[..] else { panic!("{:?}", report.notes) };
    assert_eq!(extension, "XMP_example is not used", "whatever it is");
    assert!(outside.starts_with("image 1 stays outside of the file: "), "{outside}");
    let expected = "mesh `ground` has no texture coordinates of set 0 for the normal texture of its material, which is not used there";
    assert_eq!(unused, expected, "the scene has no use for it");

    let (json, _) = parts_of(&path);
    let nodes = &json["nodes"];
    // Node 3 shows the ball outside of the scene: its mesh stays as it was.
    assert_eq!((&nodes[0]["mesh"], &nodes[3]["mesh"]), (&json!(0), &json!(1)), "ground, outside");
    assert_eq!((&nodes[1]["mesh"], &nodes[2]["mesh"]), (&json!(2), &json!(3)), "copies");
    let attributes = |mesh: usize| json["meshes"][mesh]["primitives"][0]["attributes"].as_object().unwrap();
    assert_eq!(attributes(1).len(), 2, "{:?}", attributes(1));
    assert_eq!(attributes(2).len(), 2 + 9, "{:?}", attributes(2));
    assert_eq!(attributes(2)["POSITION"], attributes(1)["POSITION"], "copies share their positions");
    assert_ne!(attributes(2)["_TRANSFER_0"], attributes(3)["_TRANSFER_0"], "and not their transfer");
    assert_eq!(json["meshes"][2]["extras"]["extras"], "a text", "extras that were no object");
    assert_eq!(json["meshes"][2]["extras"]["lobe"]["order"], 3, "extras of a mesh");
    let extras = &json["asset"]["extras"];
    assert_eq!(extras["author"], "somebody", "extras of others");
    let lobe = &extras["lobe"];
    assert_eq!(&json["scenes"][0]["extras"]["lobe"], lobe, "the scene says the same");
    assert_eq!((&lobe["version"], &lobe["channels"]), (&json!(LOBE_EXTRAS_VERSION), &json!(3)), "extras of asset");
    assert_eq!((&lobe["quantity"], &lobe["recipe"]["seed"]), (&json!("transfer"), &json!(7)), "extras of asset");
    assert_eq!(json["images"][0]["mimeType"], "image/png", "an embedded picture: {}", json["images"]);
    assert_eq!(json["images"][1], json!({"uri": "missing.png"}), "a missing picture");
    let input: Value = serde_json::from_slice(&fs::read(&input).unwrap()).unwrap();
    for pointer in
        ["/cameras", "/extensions", "/extensionsUsed", "/materials", "/textures", "/scenes/0/nodes", "/asset/copyright"]
    {
        assert_eq!(json.pointer(pointer), input.pointer(pointer), "{pointer}");
    }
}

#[test]
fn a_file_whose_nodes_were_split_differently_keeps_all_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let input = rich_file(&folder);
    let (scene, _, document) =
        GltfReader::open(&input, &SceneReadOptions::default()).and_then(GltfReader::into_scene_and_document).unwrap();
    // The ground, and one of two balls that share a mesh, which the other and a node outside keep.
    let split = scene.halve_edges(|mesh, [a, b]| mesh < 2 && (a + b) % 3 == 0).unwrap().0;
    let split = split.halve_edges(|mesh, [a, b]| mesh == 0 && (a + b) % 3 == 1).unwrap().0;
    let counts: Vec<_> = split.meshes().iter().map(|mesh| mesh.halved().len()).collect();
    assert!(counts[0] > 0 && counts[1] > 0 && counts[2] == 0, "{counts:?} edges halved");
    let transfer = transfer_of(&split, 3, Channels::Rgb);
    let path = folder.path().join("baked.glb");
    let baked = BakedGlb::of_document(document, &split).unwrap();
    baked.write(&path, &transfer, &Recipe::default(), Job::default()).unwrap();

    let found = read_baked(&path, &SceneReadOptions::default()).unwrap();
    assert_eq!(found.transfer, transfer, "transfer of all nodes");
    for (found, expected) in found.scene.meshes().iter().zip(split.meshes()) {
        assert_eq!(found.triangles(), expected.triangles(), "triangles of {}", expected.name());
        let both = found.positions().as_flattened().iter().zip(expected.positions().as_flattened());
        let off = both.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 1e-6, "positions of {} are off by {off}", expected.name());
    }
    let (json, _) = parts_of(&path);
    let count = |mesh: usize| {
        let position = &json["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"];
        json["accessors"][position.as_u64().unwrap() as usize]["count"].as_u64().unwrap() as usize
    };
    assert_eq!(count(1), scene.meshes()[1].positions().len(), "the node outside");
    let input: Value = serde_json::from_slice(&fs::read(&input).unwrap()).unwrap();
    for pointer in ["/cameras", "/extensions", "/materials", "/textures", "/scenes/0/nodes", "/asset/copyright"] {
        assert_eq!(json.pointer(pointer), input.pointer(pointer), "{pointer}");
    }
}

#[test]
fn baking_again_replaces_the_transfer_and_adds_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let input = rich_file(&folder);
    let scene = scene_of(&input);
    let [first, second, third] = ["1.glb", "2.glb", "3.glb"].map(|name| folder.path().join(name));
    let write = |from: &Path, to: &Path, order| {
        let transfer = transfer_of(&scene, order, Channels::Rgb);
        glb_of_file(from).write(to, &transfer, &Recipe::default(), Job::default()).unwrap();
    };
    write(&input, &first, 3);
    write(&first, &second, 5);
    write(&second, &third, 3);
    assert_eq!(read_baked(&second, &SceneReadOptions::default()).unwrap().transfer.order(), 5, "the later one");
    assert!(parts_of(&third) == parts_of(&first), "the same bake of the same scene gives the same file");
}

#[test]
fn compressed_transfer_comes_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let input = rich_file(&folder);
    let scene = scene_of(&input);
    let transfer = transfer_of(&scene, 3, Channels::Rgb);
    let [first, second, plain] = ["1.glb", "2.glb", "3.glb"].map(|name| folder.path().join(name));
    glb_of_file(&input).write(&plain, &transfer, &Recipe::default(), Job::default()).unwrap();
    for (components, weights) in [(5, WeightBits::F32), (4, WeightBits::U16), (3, WeightBits::U8), (0, WeightBits::U8)]
    {
        let options = CompressOptions::default().clusters(7).components(components).weights(weights);
        let (compressed, _) = CompressedTransfer::new(&transfer, &options, Job::default()).unwrap();
        glb_of_file(&input).write_compressed(&first, &compressed, &Recipe::default().scene("r".to_owned())).unwrap();
        parts_of(&first);
        let found = read_baked(&first, &SceneReadOptions::default()).unwrap();
        assert_eq!(found.compressed.as_ref(), Some(&compressed), "{components} components, {weights:?}");
        assert_eq!(found.transfer, compressed.to_transfer(), "{components} components, {weights:?}");
        assert_eq!(
            (found.recipe, found.scene.meshes().len()),
            (Recipe::default().scene("r".to_owned()), 3),
            "the rest"
        );
        // Baked again without compression, nothing of it is left.
        glb_of_file(&first).write(&second, &transfer, &Recipe::default(), Job::default()).unwrap();
        assert!(parts_of(&second) == parts_of(&plain), "{components} components, {weights:?}: left over");
    }
}

#[test]
fn compressed_transfer_that_contradicts_itself_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("baked.glb");
    let scene = built_in::closed_white_box(2);
    let options = CompressOptions::default().clusters(3).components(2);
    let (compressed, _) =
        CompressedTransfer::new(&transfer_of(&scene, 2, Channels::Gray), &options, Job::default()).unwrap();
    BakedGlb::of_scene(&scene).write_compressed(&path, &compressed, &Recipe::default()).unwrap();
    let (json, bytes) = parts_of(&path);
    for (pointer, value, part) in [
        ("/bases", json!(999), "uses buffer view 999"),
        ("/bases", json!("x"), "expected the bases of compressed transfer in base64"),
        ("/bases", json!(true), "expected bases in base64, found true"),
        ("/bases", json!(0), "expected 12 numbers for each cluster"),
        ("/bases", json!("AAAAAA=="), "expected 12 numbers for each cluster"),
        ("/compression", json!({"components": 5, "weights": "f32"}), "expected the attribute _WEIGHTS_1, found none"),
        (
            "/compression",
            json!({"components": 4_000_000_000_u64, "weights": "f32"}),
            "expected the attribute _WEIGHTS_1",
        ),
        (
            "/compression",
            json!({"components": 2, "weights": "u8"}),
            "expected whole clusters and weights of the type that it says, found ",
        ),
        (
            "/compression",
            json!({"components": 2, "weights": "f64"}),
            "expected components and weights of f32, u16 or u8",
        ),
        (
            "/compression",
            json!({"clusters": 3, "components": 0, "weights": "f32"}),
            "`bases` hold 9 clusters of 0 components, `compression` says 3",
        ),
        (
            "/compression",
            json!({"clusters": 65536, "components": 2, "weights": "f32"}),
            "`bases` hold 3 clusters of 2 components, `compression` says 65536",
        ),
        (
            "/compression",
            json!({"clusters": 0, "components": 2, "weights": "f32"}),
            "`bases` hold 3 clusters of 2 components, `compression` says 0",
        ),
        ("/compression", json!({"components": 2, "weights": "f32"}), "`compression` says null"),
    ] {
        let mut json = json.clone();
        json["asset"]["extras"]["lobe"][&pointer[1..]] = value;
        let error = read_baked(write_gltf(&folder, "changed", &json, &bytes), &SceneReadOptions::default())
            .unwrap_err()
            .to_string();
        assert!(error.contains(part) && !error.contains('\n'), "{pointer}: {error}");
    }
}

/// The refusal of a baked file after a change of its JSON.
fn refusal(change: impl FnOnce(&mut Value)) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("baked.glb");
    let scene = built_in::closed_white_box(1);
    BakedGlb::of_scene(&scene)
        .write(&path, &transfer_of(&scene, 2, Channels::Gray), &Recipe::default(), Job::default())
        .unwrap();
    let (mut json, bytes) = parts_of(&path);
    change(&mut json);
    let path = write_gltf(&folder, "changed", &json, &bytes);
    let message = read_baked(&path, &SceneReadOptions::default()).unwrap_err().to_string();
    assert!(!message.contains('\n'), "one line: {message}");
    message.strip_prefix(&format!("{}: ", path.display())).unwrap_or_else(|| panic!("no file: {message}")).to_owned()
}

/// The same after a change of the accessor of `_TRANSFER_0`.
fn refusal_of_accessor(member: &str, value: Value) -> String {
    refusal(|json| {
        let at = json["meshes"][0]["primitives"][0]["attributes"]["_TRANSFER_0"].as_u64().unwrap() as usize;
        json["accessors"][at][member] = value;
    })
}

/// The same after a change of `asset.extras.lobe`.
fn refusal_of_extras(member: &str, value: Value) -> String {
    refusal(|json| json["asset"]["extras"]["lobe"][member] = value)
}

#[test]
fn transfer_that_is_missing_of_another_type_or_newer_is_refused() {
    let missing = refusal(|json| {
        let attributes = json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap();
        attributes.remove("_TRANSFER_0");
    });
    let place = "mesh 0, primitive 0: expected";
    let left_out = "found none: another program left it out; bake again";
    assert_eq!(missing, format!("{place} the attribute _TRANSFER_0, {left_out}"), "missing");
    let missing = refusal_of_extras("order", json!(3));
    assert_eq!(missing, format!("{place} the attribute _TRANSFER_1, {left_out}"), "too few");
    for (member, value, expected) in [
        ("type", json!("VEC3"), "vectors of 4 floats as _TRANSFER_0, found 3 x F32"),
        ("componentType", json!(5123), "vectors of 4 floats as _TRANSFER_0, found 4 x U16"),
        ("count", json!(23), "24 values of _TRANSFER_0, found 23"),
    ] {
        assert_eq!(refusal_of_accessor(member, value), format!("{place} {expected}"), "{member}");
    }
    for (member, value, expected) in [
        ("version", json!(2), "baked by a newer Lobe: expected version 1 of its attributes, found 2: update Lobe"),
        ("version", json!(0), "extras.lobe: expected version 1 of Lobe's attributes, found 0"),
        ("version", json!("1"), "extras.lobe: expected version 1 of Lobe's attributes, found \"1\""),
        ("order", json!(9), "expected an order of 1 to 8 in extras.lobe, found 9"),
        ("channels", json!(2), "expected 1 or 3 channels in extras.lobe, found 2"),
        ("quantity", json!("x"), "expected the quantity \"transfer\" in extras.lobe, found \"x\""),
    ] {
        assert_eq!(refusal_of_extras(member, value), expected, "{member}");
    }
    let plain = refusal(|json| {
        let primitive = json["meshes"][0]["primitives"][0].as_object_mut().unwrap();
        primitive["attributes"].as_object_mut().unwrap().retain(|name, _| !name.starts_with('_'));
        for place in ["/asset", "/scenes/0", "/meshes/0"] {
            json.pointer_mut(place).unwrap().as_object_mut().unwrap().remove("extras");
        }
    });
    assert_eq!(plain, "carries no transfer: bake it first, with `lobe bake`", "no bake");
}

#[test]
fn what_does_not_belong_together_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let input = rich_file(&folder);
    let scene = scene_of(&input);
    let other = built_in::ball_over_ground(8);
    let document = || {
        GltfReader::open(&input, &SceneReadOptions::default()).and_then(GltfReader::into_scene_and_document).unwrap().2
    };
    let error = BakedGlb::of_document(document(), &other).unwrap_err().to_string();
    assert_eq!(error, "expected the glTF document that the scene was read with; write the scene itself", "another");
    let path = folder.path().join("baked.glb");
    let transfer = transfer_of(&other, 2, Channels::Gray);
    let error = glb_of_file(&input).write(&path, &transfer, &Recipe::default(), Job::default()).unwrap_err();
    let (expected, found) = (scene.vertex_count(), other.vertex_count());
    let message = format!("expected the transfer of {expected} vertices, found that of {found} receivers");
    assert_eq!(error.to_string(), message, "fewer receivers");
    assert!(!path.exists(), "nothing is written");
}

#[test]
fn suzi_comes_back_vertex_for_vertex() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../lobe-scene/assets/suzi.glb");
    let folder = tempfile::tempdir().unwrap();
    let scene = scene_of(&path);
    let transfer = transfer_of(&scene, 4, Channels::Rgb);
    let out = folder.path().join("suzi.glb");
    glb_of_file(&path).write(&out, &transfer, &Recipe::default(), Job::default()).unwrap();
    parts_of(&out);
    let found = read_baked(&out, &SceneReadOptions::default()).unwrap();
    assert_eq!(found.scene.meshes(), scene.meshes(), "meshes, bit for bit");
    assert_eq!(found.transfer, transfer, "transfer");
}

#[test]
fn a_file_that_is_broken_on_purpose_is_found_to_be() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("baked.glb");
    let scene = built_in::closed_white_box(1);
    BakedGlb::of_scene(&scene)
        .write(&path, &transfer_of(&scene, 2, Channels::Gray), &Recipe::default(), Job::default())
        .unwrap();
    let (json, buffer) = parts_of(&path);
    assert_eq!(glb_faults(&glb_of(&json, &buffer)), Vec::<String>::new(), "put together again");
    let attributes = &json["meshes"][0]["primitives"][0]["attributes"];
    let [position, normal, ours] =
        ["POSITION", "NORMAL", "_TRANSFER_0"].map(|name| attributes[name].as_u64().unwrap() as usize);
    let [of_normals, of_ours] =
        [normal, ours].map(|accessor| json["accessors"][accessor]["bufferView"].as_u64().unwrap());
    let indices = json["meshes"][0]["primitives"][0]["indices"].as_u64().unwrap();
    for (pointer, value, part) in [
        (format!("/bufferViews/{of_ours}/byteLength"), json!(1 << 20), "of 1"),
        (format!("/bufferViews/{of_ours}/byteLength"), json!(16), "of a view of 16"),
        (format!("/bufferViews/{of_ours}/byteStride"), json!(18), "a stride of 18"),
        (format!("/bufferViews/{of_ours}/byteStride"), json!(8), "every 8"),
        (format!("/bufferViews/{of_normals}/byteOffset"), json!(2), "of 4 bytes"),
        (format!("/accessors/{ours}/byteOffset"), json!(2), "of 4 bytes"),
        (format!("/accessors/{ours}/count"), json!(9999), "of a view of"),
        (format!("/accessors/{ours}/count"), json!(3), "3 values beside"),
        (format!("/accessors/{ours}/componentType"), json!(5124), ""),
        (format!("/accessors/{ours}/type"), json!("VEC7"), ""),
        (format!("/accessors/{ours}/bufferView"), json!(99), ""),
        (format!("/accessors/{position}/min"), json!([0.25, -1.0, -1.0]), "min is"),
        (format!("/accessors/{position}/max"), json!([1.0, 1.0]), "max is"),
        (format!("/accessors/{position}/type"), json!("VEC2"), "POSITION: 2 numbers of type 5126"),
        (format!("/accessors/{indices}/componentType"), json!(5126), "indices of type 5126"),
        ("/meshes/0/primitives/0/indices".to_owned(), json!(99), ""),
        ("/meshes/0/primitives/0/attributes/TRANSFER_0".to_owned(), json!(ours), "no attribute of glTF"),
        ("/meshes/0/primitives/0/attributes/POSITION".to_owned(), Value::Null, ""),
        ("/buffers/0/byteLength".to_owned(), json!(12), "buffer 0: 12 bytes"),
        ("/nodes/0/mesh".to_owned(), json!(7), "Index out of bounds"),
    ] {
        let mut changed = json.clone();
        let (parent, member) = pointer.rsplit_once('/').unwrap();
        changed.pointer_mut(parent).unwrap()[member] = value.clone();
        let faults = glb_faults(&glb_of(&changed, &buffer));
        assert!(faults.iter().any(|fault| fault.contains(part)), "{pointer} = {value}: {part:?} is not in {faults:?}");
    }
    let whole = glb_of(&json, &buffer);
    for end in [0, 11, 19, 40, whole.len() - 4] {
        assert_eq!(glb_faults(&whole[..end]).len(), 1, "cut off after {end} bytes");
    }
    let start = json["bufferViews"][of_normals as usize]["byteOffset"].as_u64().unwrap() as usize;
    for (number, part) in [(f32::NAN, "NaN"), (3.0, "length 3")] {
        let mut changed = buffer.clone();
        changed[start..start + 12].copy_from_slice(&[number, 0.0, 0.0].map(f32::to_le_bytes).concat());
        let faults = glb_faults(&glb_of(&json, &changed));
        assert!(faults.iter().any(|fault| fault.contains(part)), "a normal of {number}: {faults:?}");
    }
}

#[test]
fn bytes_are_read_as_the_file_is_and_a_bake_of_another_version_is_not_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("baked.glb");
    let scene = built_in::closed_white_box(1);
    let transfer = transfer_of(&scene, 2, Channels::Gray);
    BakedGlb::of_scene(&scene).write(&path, &transfer, &Recipe::default().samples(7), Job::default()).unwrap();
    let (bytes, options) = (fs::read(&path).unwrap(), SceneReadOptions::default());
    let baked = read_baked_bytes(&bytes, "a.glb", &options).unwrap();
    assert_eq!((&baked.transfer, baked.recipe.samples), (&transfer, Some(7)), "transfer and recipe");
    let BakedOrScene::Baked(either) = read_baked_or_scene_bytes(&bytes, "a.glb", &options).unwrap() else {
        panic!("it is baked")
    };
    assert_eq!(either.transfer, transfer, "baked or not");
    let error = read_baked_bytes(&bytes[..99], "a.glb", &options).unwrap_err().to_string();
    assert!(error.starts_with("a.glb: "), "{error}");

    let (scene, _, mut document) =
        GltfReader::open_bytes(&bytes, "a.glb", &options).and_then(GltfReader::into_scene_and_document).unwrap();
    document.json["asset"]["extras"]["lobe"]["version"] = json!(2);
    let error = BakedGlb::of_document(document, &scene).unwrap_err();
    assert!(matches!(error, PrtError::Unsupported { .. }), "{error:?}");
    assert!(error.to_string().contains("baked by a newer Lobe"), "{error}");
}
