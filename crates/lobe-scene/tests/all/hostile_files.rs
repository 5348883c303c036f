//! Small files that ask for much, and JSON of a wrong kind: they are refused in one line.

use std::fs;

use lobe_scene::{
    AnimatedScene, GltfReader, Material, Mesh, MeshParts, MissingNormals, NormalMap, Scene, SceneError,
    SceneReadOption, SceneReadOptions, TextureUse, read_scene, read_scene_bytes,
};
use serde_json::{Value, json};

use crate::common::{Gltf, base64};

fn refusal(file: &Gltf, options: &SceneReadOptions) -> SceneError {
    read_scene_bytes(&file.glb(), "a.glb", options).map(|_| ()).unwrap_err()
}

/// The pointers of all members of a JSON value, and of theirs.
pub(crate) fn pointers(json: &Value, at: &str, found: &mut Vec<String>) {
    let members: Vec<(String, &Value)> = match json {
        Value::Array(items) => items.iter().enumerate().map(|(k, item)| (k.to_string(), item)).collect(),
        Value::Object(members) => members.iter().map(|(name, item)| (name.clone(), item)).collect(),
        _ => Vec::new(),
    };
    for (name, item) in members {
        let at = format!("{at}/{name}");
        pointers(item, &at, found);
        found.push(at);
    }
}

#[test]
fn json_of_a_wrong_kind_is_read_or_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let file = Gltf::square().with_attribute("COLOR_0", "VEC4", &[0.5; 16]);
    let mesh = json!([null, null, null, [{"attributes": {}}], null]);
    let mut all = Vec::new();
    pointers(&file.json, "", &mut all);
    let options = SceneReadOptions::default();
    for pointer in &all {
        for value in [json!([]), json!({}), json!(null), json!("a"), json!(u64::MAX), mesh.clone()] {
            let changed = Gltf { json: file.json.clone(), buffer: file.buffer.clone() }.with(pointer, value.clone());
            fs::write(&path, changed.glb()).unwrap();
            let found = [
                read_scene(&path, &options).map(|_| ()),
                GltfReader::open(&path, &options).and_then(GltfReader::into_scene_and_document).map(|_| ()),
            ];
            for error in found.into_iter().filter_map(Result::err) {
                let message = error.to_string();
                assert!(!message.contains('\n'), "{pointer} as {value}: {message:?}");
            }
        }
    }
    let found = refusal(&file.with("/meshes/0", mesh), &options).to_string();
    let expected = "a.glb: expected glTF, found an error at meshes[0]: expected objects, found another kind of JSON";
    assert_eq!(found, expected, "a mesh written as an array");
}

#[test]
fn offsets_near_the_largest_number_are_outside_of_the_buffer() {
    let file = Gltf::square().with("/accessors/0/byteOffset", json!(u64::MAX - 11));
    let found = refusal(&file, &SceneReadOptions::default()).to_string();
    let place = "a.glb: mesh `square`, primitive 0: accessor 0";
    assert_eq!(found, format!("{place}: 4 elements do not fit into a buffer view of 48 bytes"), "message");
}

#[test]
fn instances_in_arrays_are_counted_before_they_become_nodes() {
    let name = "EXT_mesh_gpu_instancing";
    let count = 1_u64 << 26;
    let file = Gltf::square()
        .with("/accessors/2", json!({"componentType": 5126, "count": count, "type": "VEC3"}))
        .with("/nodes/0/extensions", json!({name: {"attributes": {"TRANSLATION": 2}}}));
    let found = refusal(&file, &SceneReadOptions::default()).to_string();
    let expected = "a.glb: expected at most 67108864 triangles and vertices, found 134217728 and 268435456 or more: raise \
                    SceneReadOptions::max_triangles";
    assert_eq!(found, expected, "two triangles and four vertices each");
    let empty = file.with("/meshes/0/primitives", json!([]));
    let error = refusal(&empty, &SceneReadOptions::default().max_bytes(1 << 20));
    assert!(
        matches!(error, SceneError::Refused { option: SceneReadOption::MaxBytes, .. }),
        "of an empty mesh: {error}"
    );
}

#[test]
fn instances_that_no_scene_shows_stay_in_their_arrays() {
    let instanced = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}});
    let file = Gltf::square()
        .with("/accessors/2", json!({"componentType": 5126, "count": 1_u64 << 40, "type": "VEC3"}))
        .with("/extensionsUsed", json!(["EXT_mesh_gpu_instancing"]))
        .with("/nodes/1", json!({"mesh": 0, "extensions": instanced}));
    let options = SceneReadOptions::default().max_bytes(1 << 20);
    let reader = GltfReader::open_bytes(&file.glb(), "a.glb", &options).unwrap();
    let (scene, _, document) = reader.into_scene_and_document().unwrap();
    assert_eq!(scene.triangle_count(), 2, "the node that is shown");
    for member in ["nodes", "extensionsUsed"] {
        assert_eq!(document.json[member], file.json[member], "{member}");
    }
}

#[test]
fn attributes_of_another_length_are_not_copied_to_make_triangles_flat() {
    let mut file = Gltf::square();
    // The square is folded along its diagonal.
    file.buffer[44..48].copy_from_slice(&1_f32.to_le_bytes());
    let file = file
        .with("/accessors/2", json!({"componentType": 5126, "count": 1_u64 << 26, "type": "MAT4"}))
        .with("/meshes/0/primitives/0/attributes/_A", json!(2));
    let found = refusal(&file, &SceneReadOptions::default()).to_string();
    let expected = "a.glb: mesh `square`, primitive 0: expected 4 elements in accessor 2, found 67108864";
    assert_eq!(found, expected, "message");
}

#[test]
fn vertices_added_to_make_triangles_flat_count_against_the_limit() {
    let roof = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nf 1 2 3 4\nf 2 1 5 6\n";
    let read = |normals| {
        let options = SceneReadOptions::default().max_triangles(7).missing_normals(normals);
        read_scene_bytes(roof.as_bytes(), "a.obj", &options).map(|(scene, _)| scene.vertex_count())
    };
    let smooth = read(MissingNormals::Smooth);
    assert!(matches!(smooth, Ok(6)), "six vertices as they are: {smooth:?}");
    let flat = read(MissingNormals::Flat);
    assert!(matches!(flat, Err(SceneError::Refused { .. })), "eight of them: {flat:?}");
}

#[test]
fn of_many_notes_the_first_are_kept_and_the_others_counted() {
    let shiny =
        |k: i32| json!({"name": format!("m{k}"), "pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}}});
    let materials: Vec<_> = (0..150).map(shiny).collect();
    let file = Gltf::square().with("/materials", json!(materials));
    let (_, report) = read_scene_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).unwrap();
    assert_eq!(report.notes.len(), 101, "{:?}", report.notes);
    let expected = "material `m99` has a metallic-roughness texture, which is not used: surfaces are matte";
    assert_eq!(report.notes[99], expected, "the last that is kept");
    assert_eq!(report.notes[100], "and 50 more notes", "the rest");
}

#[test]
fn names_of_missing_files_stay_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    let file = Gltf::square().with("/buffers/0/uri", json!("\u{1b}[2J\nx.bin"));
    fs::write(&path, file.json.to_string()).unwrap();
    let error = read_scene(&path, &SceneReadOptions::default()).map(|_| ()).unwrap_err();
    assert!(matches!(error, SceneError::Io { .. }), "{error:?}");
    let message = error.to_string();
    assert!(!message.contains(char::is_control), "{message:?}");
}

#[test]
fn an_obj_in_utf_16_is_named_as_such_and_a_byte_order_mark_of_utf_8_is_skipped() {
    let read = |bytes: &[u8]| read_scene_bytes(bytes, "a.obj", &SceneReadOptions::default());
    for bytes in [b"\xFF\xFEv\0", b"\xFE\xFF\0v"] {
        let error = read(&bytes[..]).map(|_| ()).unwrap_err().to_string();
        assert_eq!(error, "a.obj: expected UTF-8 or Latin-1, found UTF-16", "message");
    }
    let (scene, _) = read("\u{feff}v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n".as_bytes()).unwrap();
    assert_eq!(scene.vertex_count(), 3, "the first line counts");
}

#[test]
fn materials_named_many_times_are_read_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    fs::write(folder.path().join("a.mtl"), format!("newmtl a\nKd 1 1 1\n#{}\n", "x".repeat(1000))).unwrap();
    fs::write(&path, "mtllib a.mtl\n".repeat(100) + "v 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl a\nf 1 2 3\n").unwrap();
    let (scene, _) = read_scene(&path, &SceneReadOptions::default().max_bytes(10_000)).unwrap();
    assert_eq!(scene.materials().len(), 1, "materials");
    let error = read_scene(&path, &SceneReadOptions::default().max_bytes(500)).map(|_| ()).unwrap_err();
    assert!(matches!(error, SceneError::Refused { option: SceneReadOption::MaxBytes, .. }), "it counts: {error}");
}

#[test]
fn scenes_of_materials_out_of_range_are_refused() {
    let used = TextureUse { texture: 0, uv_set: 0, uv_map: TextureUse::UV_UNCHANGED };
    let texture = |used| Material { base_color_texture: Some(used), ..Material::WHITE };
    let normals = |used, scale| Material { normal_map: Some(NormalMap { used, scale }), ..Material::WHITE };
    for (material, expected) in [
        (Material { transmission: 5.0, ..Material::WHITE }, "transmission from 0 to 1, found"),
        (Material { roughness: f32::NAN, ..Material::WHITE }, "transmission from 0 to 1, found"),
        (Material { emissive: [f32::NAN, 0.0, 0.0], ..Material::WHITE }, "expected a finite emission"),
        (texture(TextureUse { uv_set: 2, ..used }), "expected texture coordinates of set 0 or 1, found 2"),
        (texture(TextureUse { uv_map: [[f32::INFINITY; 3]; 2], ..used }), "expected a finite map of its texture"),
        (normals(TextureUse { uv_set: 2, ..used }, 1.0), "expected texture coordinates of set 0 or 1, found 2"),
        (normals(TextureUse { texture: 1, ..used }, 1.0), "uses texture 1, but there are 1"),
        (normals(used, f32::NAN), "expected a finite scale of its normal map, found NaN"),
    ] {
        let parts = MeshParts {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            material: Some(0),
            ..MeshParts::default()
        };
        let white = lobe_scene::Texture::new(1, 1, vec![[255; 4]], [lobe_scene::Wrap::Repeat; 2]);
        let error = Scene::new(vec![Mesh::new(parts).unwrap()], vec![material], vec![white]).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains(expected), "{expected}: {error}");
    }
}

#[test]
fn a_file_that_is_longer_than_allowed_is_refused_before_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let options = SceneReadOptions::default().max_bytes(1 << 20);
    for name in ["a.obj", "a.ply", "a.gltf", "a.glb", "a.vrm"] {
        let path = folder.path().join(name);
        // 64 GiB of nothing, which would not fit into the memory of most machines.
        fs::File::create(&path).unwrap().set_len(1 << 36).unwrap();
        let found = [
            read_scene(&path, &options).map(|_| ()),
            GltfReader::open(&path, &options).map(|_| ()),
            AnimatedScene::read(&path, &options).map(|_| ()),
        ];
        for error in found.into_iter().map(Result::unwrap_err) {
            let expected =
                "expected a file of at most 1048576 bytes, found 68719476736: raise SceneReadOptions::max_bytes";
            assert!(error.to_string().ends_with(expected), "{name}: {error}");
        }
    }
}

#[test]
fn buffers_that_are_put_together_count_against_the_limit_and_a_single_one_is_not_held_twice() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    // A megabyte that a buffer view has, though nothing shows it; triangles without normals add buffers.
    let length = 1 << 20;
    fs::write(folder.path().join("big.bin"), vec![0; length]).unwrap();
    let file = Gltf::square();
    let small = json!({"byteLength": file.buffer.len(), "uri": format!("data:;base64,{}", base64(&file.buffer))});
    let file = file
        .with("/buffers", json!([small, {"byteLength": length, "uri": "big.bin"}]))
        .with("/bufferViews/2", json!({"buffer": 1, "byteLength": length}));
    fs::write(&path, file.json.to_string()).unwrap();
    let read = |limit: u64| {
        let options = SceneReadOptions::default().max_bytes(limit);
        GltfReader::open(&path, &options).and_then(GltfReader::into_scene_and_document)
    };
    let error = read(3 * length as u64 / 2).map(|_| ()).unwrap_err();
    assert!(matches!(error, SceneError::Refused { option: SceneReadOption::MaxBytes, .. }), "{error}");
    let (_, _, document) = read(5 * length as u64 / 2).unwrap();
    assert!(document.bytes.capacity() < length + 1000, "reserved {} for {length}", document.bytes.capacity());
    // A .glb has one buffer, which stays where it was read.
    let path = folder.path().join("a.glb");
    let mut file = Gltf::square();
    file.floats("SCALAR", &vec![0.0; length / 4]);
    fs::write(&path, file.glb()).unwrap();
    let options = SceneReadOptions::default().max_bytes(5 * length as u64 / 4);
    let scene = GltfReader::open(&path, &options).and_then(|gltf| gltf.scene()).map(|_| ());
    assert!(scene.is_ok(), "{scene:?}");
}

#[test]
fn lists_that_a_file_makes_no_mesh_of_count_against_the_limit_of_bytes() {
    const LINES: usize = 1 << 17;
    let lines = |line: &str| format!("v 0 0 0\n{}", line.repeat(LINES)).into_bytes();
    let latin_1 = [b"# ", &vec![0xDF_u8; 1 << 20][..], b"\nv 0 0 0\n"].concat();
    let head = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {LINES}\nproperty uchar x\nproperty uchar y\n\
         property uchar z\nend_header\n"
    );
    let ply = [head.as_bytes(), &vec![0; 3 * LINES]].concat();
    for (name, bytes, limit) in [
        ("v.obj", lines("v 0 0 0\n"), 4 << 20),
        ("vt.obj", lines("vt 0 0\n"), 2 << 20),
        ("vn.obj", lines("vn 0 0 1\n"), 3 << 20),
        ("c.obj", lines("v 0 0 0 1 1 1\n"), 8 << 20),
        ("f.obj", lines("f 1 1 1\n"), 8 << 20),
        ("latin.obj", latin_1, 3 << 20),
        ("a.ply", ply, 16 << 20),
    ] {
        let read = |limit| read_scene_bytes(&bytes, name, &SceneReadOptions::default().max_bytes(limit));
        let error = read(limit).unwrap_err().to_string();
        assert!(error.contains("max_bytes"), "{name} of {} bytes with {limit}: {error}", bytes.len());
        let error = read(u64::MAX).unwrap_err().to_string();
        assert!(error.contains("expected triangles"), "{name} without a limit: {error}");
    }
}
