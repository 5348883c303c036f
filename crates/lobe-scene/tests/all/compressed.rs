//! Compressed glTF files, and instances in arrays, are read as if they were plain; so are written ones.

use std::fs;

use lobe_scene::{
    DefaultMaterial, GltfDocument, GltfReader, MissingNormals, Scene, SceneError, SceneReadOption, SceneReadOptions,
    read_scene_bytes,
};
use meshoptimizer_rs::Workspace;
use meshoptimizer_rs::codec::{VertexEncoding, encode_index_buffer, encode_vertex_buffer};
use serde_json::{Value, json};

use crate::common::Gltf;

/// Reads a file as scene and document, and the document as a scene: both are the same.
fn read(file: &Gltf) -> (Scene, GltfDocument) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    fs::write(&path, file.glb()).unwrap();
    let (scene, _, document) =
        GltfReader::open(&path, &SceneReadOptions::default()).and_then(GltfReader::into_scene_and_document).unwrap();
    let plain = Gltf { json: document.json.clone(), buffer: document.bytes.clone() };
    let again = read_scene_bytes(&plain.glb(), "again.glb", &SceneReadOptions::default()).unwrap().0;
    assert_eq!(again.meshes(), scene.meshes(), "the document holds the scene");
    (scene, document)
}

fn refusal(file: &Gltf) -> String {
    read_scene_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).map(|_| ()).unwrap_err().to_string()
}

/// The square of `Gltf::square` as the encoder of draco-core 2.3.3 stores it, with its corners as texture coordinates:
/// attributes 0 and 1, quantized to 8 bits.
const DRACO_SQUARE: &[u8] = &[
    68, 82, 65, 67, 79, 2, 2, 1, 1, 0, 0, 0, 4, 2, 1, 2, 0, 0, 1, 31, 255, 1, 17, 255, 1, 17, 2, 255, 0, 0, 0, 0, 0, 1,
    0, 9, 3, 0, 0, 2, 1, 3, 9, 2, 0, 1, 2, 1, 1, 1, 0, 3, 3, 1, 48, 1, 16, 3, 0, 40, 130, 152, 0, 0, 0, 0, 0, 255, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 128, 63, 8, 1, 1, 1, 0, 3, 3, 1, 48, 1, 16, 3, 0, 40, 130, 44, 0,
    0, 0, 0, 0, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 128, 63, 8,
];

fn draco_square() -> Gltf {
    let name = "KHR_draco_mesh_compression";
    let compressed = json!({"bufferView": 0, "attributes": {"POSITION": 0, "TEXCOORD_0": 1}});
    let mut file = Gltf::square()
        .with("/extensionsUsed", json!([name]))
        .with("/extensionsRequired", json!([name]))
        .with("/meshes/0/primitives/0/extensions", json!({name: compressed}))
        .with("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(2))
        .with(
            "/accessors",
            json!([
                {"componentType": 5126, "count": 4, "type": "VEC3"},
                {"componentType": 5123, "count": 6, "type": "SCALAR"},
                {"componentType": 5126, "count": 4, "type": "VEC2"},
            ]),
        )
        .with("/bufferViews", json!([{"buffer": 0, "byteLength": DRACO_SQUARE.len()}]))
        .with("/buffers/0/byteLength", json!(DRACO_SQUARE.len()));
    file.buffer = DRACO_SQUARE.to_vec();
    file
}

#[test]
fn draco_meshes_are_read_and_written_plain() {
    let (scene, document) = read(&draco_square());
    let mesh = &scene.meshes()[0];
    assert_eq!((mesh.positions().len(), mesh.triangles().len()), (4, 2), "vertices and triangles");
    for (p, uv) in mesh.positions().iter().zip(mesh.uvs(0)) {
        assert_eq!([p[0], p[2]], *uv, "corners are their own texture coordinates");
    }
    assert_eq!(mesh.normals(), [[0.0, -1.0, 0.0]; 4], "both triangles face the same way");
    assert_eq!(document.json["extensionsRequired"], Value::Null, "nothing is required any more");
    assert_eq!(document.json["meshes"][0]["primitives"][0]["extensions"], Value::Null, "nor used");
    let (strip, document) = read(&draco_square().with("/meshes/0/primitives/0/mode", json!(5)));
    assert_eq!(strip.meshes()[0].triangles(), mesh.triangles(), "a list, also where the file says a strip");
    assert_eq!(document.json["meshes"][0]["primitives"][0]["mode"], 4, "and it is written as a list");
}

#[test]
fn damaged_draco_meshes_are_refused_in_one_line() {
    let mut random = lobe_testkit::Random::new(3);
    for _ in 0..300 {
        let mut file = draco_square();
        let at = random.next_u64() as usize % file.buffer.len();
        file.buffer[at] = random.next_u64() as u8;
        if let Err(error) = read_scene_bytes(&file.glb(), "a.glb", &SceneReadOptions::default().max_triangles(1 << 16))
        {
            let message = error.to_string();
            assert!(message.starts_with("a.glb: ") && !message.contains('\n'), "byte {at}: {message:?}");
        }
    }
    let found = refusal(&draco_square().with("/accessors/0/count", json!(5)));
    let expected = "a.glb: mesh 0, primitive 0: Draco compression: holds 4 elements where an accessor says 5";
    assert_eq!(found, expected, "another count");
}

/// The square with both of its views compressed, the plain bytes in a buffer that is not there.
fn meshopt_square() -> Gltf {
    let name = "EXT_meshopt_compression";
    let mut file = Gltf::square();
    let mut workspace = Workspace::default();
    let version = VertexEncoding::new(0, 2).unwrap();
    let positions = encode_vertex_buffer(&file.buffer[..48], 4, 12, version, &mut workspace).unwrap();
    let indices = encode_index_buffer(&[0, 1, 2, 0, 2, 3], Default::default(), &mut workspace).unwrap();
    let view = |offset: usize, length: usize, count: usize, stride: usize, mode: &str| {
        let compressed = json!({"buffer": 0, "byteOffset": offset, "byteLength": length, "byteStride": stride,
            "count": count, "mode": mode});
        json!({"buffer": 1, "byteLength": count * stride, "extensions": {name: compressed}})
    };
    let start = positions.len().next_multiple_of(4);
    file.buffer = positions.clone();
    file.buffer.resize(start, 0);
    file.buffer.extend_from_slice(&indices);
    file.with("/extensionsUsed", json!([name, "KHR_mesh_quantization"]))
        .with("/extensionsRequired", json!([name]))
        .with(
            "/bufferViews",
            json!([view(0, positions.len(), 4, 12, "ATTRIBUTES"), view(start, indices.len(), 6, 2, "TRIANGLES"),]),
        )
        .with(
            "/buffers",
            json!([
                {"byteLength": start + indices.len()},
                {"byteLength": 60, "extensions": {name: {"fallback": true}}},
            ]),
        )
}

#[test]
fn meshopt_buffer_views_are_read_and_written_plain() {
    let (scene, document) = read(&meshopt_square());
    let plain = read(&Gltf::square()).0;
    assert_eq!(scene.meshes()[0].positions(), plain.meshes()[0].positions(), "positions");
    assert_eq!(scene.triangle_count(), 2, "triangles");
    assert_eq!(document.json["extensionsUsed"], json!(["KHR_mesh_quantization"]), "other extensions stay");
    assert_eq!(document.bytes.len(), 60, "of the compressed bytes nothing is left");
    assert_eq!(document.json["bufferViews"][0]["byteStride"], 12, "elements stand as far apart as they were stored");
    let other = read(&meshopt_square().with("/buffers/0/extensions", json!({"ACME_origin": 1}))).1;
    assert_eq!(other.json["buffers"][0]["extensions"], json!({"ACME_origin": 1}), "extensions of others stay");
    let compressed = "/bufferViews/0/extensions/EXT_meshopt_compression";
    for (member, value, expected) in [
        ("count", json!(1_u64 << 40), "1099511627776 elements of 12 bytes are more than the limit"),
        ("byteLength", json!(1000), "1000 bytes from 0 are not in its buffer"),
        ("buffer", json!(7), "are not in its buffer"),
        ("filter", json!("COLOR"), "filter COLOR is not known: decompress it with `gltf-transform copy IN OUT`"),
        ("byteOffset", json!(4), "expected meshoptimizer's bytes, found an error: "),
        ("count", json!("a"), "expected a whole number as count, found \"a\""),
    ] {
        let found = refusal(&meshopt_square().with(&format!("{compressed}/{member}"), value));
        let place = "a.glb: meshopt compression of buffer view 0: ";
        assert!(found.starts_with(place) && found.contains(expected), "{member}: {found}");
    }
}

#[test]
fn compressed_bytes_named_many_times_count_each_time() {
    let options = SceneReadOptions::default().max_bytes(20_000);
    let mut file = meshopt_square();
    assert!(read_scene_bytes(&file.glb(), "a.glb", &options).is_ok(), "48 and 12 bytes are little");
    let view = file.json["bufferViews"][0].clone();
    file.json["bufferViews"].as_array_mut().unwrap().extend(vec![view; 1000]);
    let error = read_scene_bytes(&file.glb(), "a.glb", &options).map(|_| ()).unwrap_err();
    assert!(matches!(error, SceneError::Refused { option: SceneReadOption::MaxBytes, .. }), "{error}");
}

#[test]
fn instances_kept_as_arrays_become_nodes() {
    let name = "EXT_mesh_gpu_instancing";
    let file = Gltf::square()
        .with_attribute("_SHIFT", "VEC3", &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 4.0, 0.0, 0.0, 6.0, 0.0, 0.0])
        .with_attribute("_SCALE", "VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
        .with("/meshes/0/primitives/0/attributes", json!({"POSITION": 0}))
        .with("/nodes/0/translation", json!([0.0, 10.0, 0.0]))
        .with("/nodes/0/extensions", json!({name: {"attributes": {"TRANSLATION": 2, "SCALE": 3}}}))
        .with("/extensionsRequired", json!([name]));
    let (scene, document) = read(&file);
    let corners: Vec<_> = scene.meshes().iter().map(|mesh| mesh.positions()[2]).collect();
    let expected = [[1.0, 0.0, 11.0], [4.0, 0.0, 12.0], [5.0, 0.0, 11.0], [7.0, 0.0, 11.0]];
    assert_eq!(corners, expected, "the far corner of each, z up");
    assert_eq!(document.json["nodes"].as_array().unwrap().len(), 5, "a node for each");
    let few = SceneReadOptions::default().max_triangles(3);
    let error = read_scene_bytes(&file.glb(), "a.glb", &few).unwrap_err().to_string();
    assert!(error.starts_with("a.glb: expected at most 3 triangles and vertices"), "{error}");
    let turned = file.with("/nodes/0/extensions", json!({name: {"attributes": {"ROTATION": 2}}}));
    let expected = "a.glb: node 0, EXT_mesh_gpu_instancing: expected vectors of 4 floats as ROTATION, found 3 x F32";
    assert_eq!(refusal(&turned), expected, "three numbers are no rotation");
    let file = turned.with("/nodes/0/extensions", json!({name: {"attributes": {"TRANSLATION": 2, "SCALE": 3}}}));
    let uneven = refusal(&file.with("/accessors/3/count", json!(3)));
    assert_eq!(uneven, "a.glb: node 0, EXT_mesh_gpu_instancing: the attributes have [4, 3] elements", "uneven");
}

/// Seeds of the fuzz target of scenes: each kind of compression once, pictures in the buffer, where they can be damaged.
#[test]
#[ignore = "writes files: LOBE_SEEDS=FOLDER cargo test -p lobe-scene --test all -- --ignored write_the_seeds"]
fn write_the_seeds() {
    let Some(folder) = std::env::var_os("LOBE_SEEDS").map(std::path::PathBuf::from) else {
        lobe_testkit::skipped("the seeds of compressed scenes: no LOBE_SEEDS says where to");
        return;
    };
    let embedded = |picture: &[u8], kind: &str, extension: &str| {
        let (_, document) = read(&textured(picture, kind, extension));
        Gltf { json: document.json, buffer: document.bytes }
    };
    for (name, file) in [
        ("draco", draco_square()),
        ("meshopt", meshopt_square()),
        ("webp", embedded(&webp(), "image/webp", "EXT_texture_webp")),
        ("basis", embedded(&uastc([9, 8, 7, 6]), "image/ktx2", "KHR_texture_basisu")),
    ] {
        fs::write(folder.join(format!("{name}.glb")), file.glb()).unwrap();
    }
}

/// A file whose square has the one color of this picture, and the extension that names it.
fn textured(picture: &[u8], kind: &str, extension: &str) -> Gltf {
    let uri = format!("data:{kind};base64,{}", crate::common::base64(picture));
    Gltf::square()
        .with_attribute("TEXCOORD_0", "VEC2", &[0.5; 8])
        .with("/meshes/0/primitives/0/material", json!(0))
        .with("/materials", json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]))
        .with("/textures", json!([{"extensions": {extension: {"source": 0}}}]))
        .with("/images", json!([{"uri": uri}]))
        .with("/extensionsRequired", json!([extension]))
}

/// A KTX2 of 4 x 4 texels of one color: a block of UASTC in mode 8, which holds nothing but that.
fn uastc([r, g, b, a]: [u8; 4]) -> Vec<u8> {
    let words = |words: &[u32]| words.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>();
    let mut ktx2 = b"\xABKTX 20\xBB\r\n\x1A\n".to_vec();
    let dfd = [44, 0, 2 | 40 << 16, 166 | 1 << 8 | 2 << 16, 3 | 3 << 8, 16, 0, 127 << 16 | 3 << 24, 0, 0, u32::MAX];
    // Format, size of its type, size, depth, layers, faces, levels and supercompression; then where all the rest is.
    ktx2.extend(words(&[0, 1, 4, 4, 0, 0, 1, 1, 0]));
    ktx2.extend(words(&[104, 44, 0, 0, 0, 0, 0, 0]));
    ktx2.extend([160_u64, 16, 16].iter().flat_map(|w| w.to_le_bytes()));
    ktx2.extend(words(&dfd));
    ktx2.resize(160, 0);
    let color = [r, g, b, a].iter().rev().fold(0_u128, |bits, &c| bits << 8 | u128::from(c));
    ktx2.extend((0x17 | color << 5).to_le_bytes());
    ktx2
}

/// A WebP of 2 x 2 texels.
fn webp() -> Vec<u8> {
    let mut bytes = Vec::new();
    let picture = [255, 0, 255, 0].repeat(4);
    image_webp::WebPEncoder::new(&mut bytes).encode(&picture, 2, 2, image_webp::ColorType::Rgba8).unwrap();
    bytes
}

#[test]
fn webp_and_basis_universal_textures_are_read() {
    for (bytes, kind, extension) in
        [(webp(), "image/webp", "EXT_texture_webp"), (uastc([255, 0, 255, 0]), "image/ktx2", "KHR_texture_basisu")]
    {
        let (scene, document) = read(&textured(&bytes, kind, extension));
        assert_eq!(scene.vertex_base_color(0, 0), [1.0, 0.0, 1.0, 0.0], "{extension}");
        assert_eq!(document.json["images"][0]["mimeType"], kind, "kept as it is");
        for length in 1..bytes.len() {
            let cut = textured(&bytes[..length], kind, extension);
            if let Err(error) = read_scene_bytes(&cut.glb(), "a.glb", &SceneReadOptions::default()) {
                let message = error.to_string();
                assert!(message.starts_with("a.glb: ") && !message.contains('\n'), "{length} bytes: {message}");
            }
        }
        let found = refusal(&textured(&bytes[..bytes.len() / 2], kind, extension));
        assert!(found.starts_with("a.glb: image 0: expected "), "half of it: {found}");
    }
    let mut large = uastc([0; 4]);
    large[20..24].copy_from_slice(&u32::MAX.to_le_bytes());
    let found = refusal(&textured(&large, "image/ktx2", "KHR_texture_basisu"));
    assert!(found.contains("expected textures of at most 268435456 texels"), "{found}");
    let mut claims = uastc([0; 4]);
    claims[44..48].copy_from_slice(&2_u32.to_le_bytes());
    claims[96..104].copy_from_slice(&(1_u64 << 50).to_le_bytes());
    let found = refusal(&textured(&claims, "image/ktx2", "KHR_texture_basisu"));
    let expected = "a.glb: image 0: expected at most 16 bytes in the first level of the KTX2, found 1125899906842624";
    assert_eq!(found, expected, "a level that claims more than its texels take");
    for (offset, length) in [(u64::MAX - 7, 16), (160, 17), (1 << 40, 16), (160, u64::MAX)] {
        let mut elsewhere = uastc([0; 4]);
        elsewhere[80..88].copy_from_slice(&u64::to_le_bytes(offset));
        elsewhere[88..96].copy_from_slice(&u64::to_le_bytes(length));
        let found = refusal(&textured(&elsewhere, "image/ktx2", "KHR_texture_basisu"));
        let expected = format!(
            "a.glb: image 0: expected the first level of the KTX2 within its 176 bytes, found {length} at byte {offset}"
        );
        assert_eq!(found, expected, "a level that is not in the file");
    }
    let mut faces = uastc([0; 4]);
    faces[36..40].copy_from_slice(&6_u32.to_le_bytes());
    let found = refusal(&textured(&faces, "image/ktx2", "KHR_texture_basisu"));
    assert_eq!(found, "a.glb: image 0: expected a plain picture in the KTX2, found layers or faces", "a cube");
}

/// Two squares that share an edge and have no normals: 6 vertices, of which the edge's two get others.
fn roof() -> Gltf {
    let positions: [[f32; 3]; 6] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    let indices: [u16; 12] = [0, 1, 2, 0, 2, 3, 1, 0, 4, 1, 4, 5];
    let mut file = Gltf::square();
    file.buffer = positions.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    file.buffer.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    file.with("/buffers/0/byteLength", json!(96))
        .with("/bufferViews/0/byteLength", json!(72))
        .with("/bufferViews/1", json!({"buffer": 0, "byteOffset": 72, "byteLength": 24}))
        .with("/accessors/0/count", json!(6))
        .with("/accessors/1/count", json!(12))
}

#[test]
fn meshes_without_normals_are_flat_as_gltf_asks_unless_they_are_to_be_smooth() {
    let colors: Vec<f32> = (0..24).map(|i| i as f32 / 24.0).collect();
    let mut file = roof().with_attribute("COLOR_0", "VEC4", &colors);
    file.json["accessors"][2]["count"] = json!(6);
    let (scene, document) = read(&file);
    let mesh = &scene.meshes()[0];
    assert_eq!((mesh.positions().len(), mesh.triangles().len()), (8, 4), "two vertices more");
    for t in mesh.triangles() {
        let [a, b, c] = t.map(|i| mesh.normals()[i as usize]);
        assert!(a == b && b == c, "one normal for each triangle: {a:?} {b:?} {c:?}");
    }
    for (i, p) in mesh.positions().iter().enumerate().skip(6) {
        let first = mesh.positions()[..6].iter().position(|q| q == p).unwrap();
        assert_eq!(mesh.colors()[i], mesh.colors()[first], "a copy has all its attributes");
    }
    assert_eq!(document.json["accessors"].as_array().unwrap().len(), 6, "the old ones stay where they were");
    let options = SceneReadOptions::default().missing_normals(MissingNormals::Smooth);
    let smooth = read_scene_bytes(&file.glb(), "a.glb", &options).unwrap().0;
    let half = 0.5_f32.sqrt();
    let found = smooth.meshes()[0].normals()[0];
    assert!((found[1] + half).abs() < 1e-6 && (found[2] - half).abs() < 1e-6, "the mean of both sides: {found:?}");
    assert_eq!(smooth.meshes()[0].positions().len(), 6, "as many vertices as in the file");
    let (_, _, document) =
        GltfReader::open_bytes(&file.glb(), "a.glb", &options).and_then(GltfReader::into_scene_and_document).unwrap();
    let written = Gltf { json: document.json, buffer: document.bytes };
    let (again, report) = read_scene_bytes(&written.glb(), "a.glb", &SceneReadOptions::default()).unwrap();
    assert_eq!(again.meshes()[0].normals(), smooth.meshes()[0].normals(), "what is written of it is as smooth");
    assert_eq!(report.made_normals, 0, "as its normals are there");
}

#[test]
fn a_mesh_without_a_material_is_white_or_what_gltf_says() {
    let read = |options: &SceneReadOptions| {
        let (scene, _) = read_scene_bytes(&Gltf::square().glb(), "a.glb", options).unwrap();
        let material = scene.material(0);
        (material.base_color, material.metallic, material.roughness, material.double_sided)
    };
    assert_eq!(read(&SceneReadOptions::default()), ([1.0; 4], 0.0, 1.0, true), "ours");
    let options = SceneReadOptions::default().default_material(DefaultMaterial::AsFormat);
    assert_eq!(read(&options), ([1.0; 4], 1.0, 1.0, false), "glTF's");
}
