//! glTF files that are read, and those refused in one line.

use std::fs;
use std::path::Path;

use crate::common::Gltf;
use lobe_scene::{
    Alpha, MeshSource, Scene, SceneError, SceneReadOptions, SceneReadReport, Texture, Wrap, read_scene,
    read_scene_bytes,
};
use serde_json::json;

fn read(file: &Gltf) -> Result<(Scene, SceneReadReport), SceneError> {
    read_scene_bytes(&file.glb(), "a.glb", &SceneReadOptions::default())
}

fn scene(file: &Gltf) -> Scene {
    read(file).unwrap().0
}

#[test]
fn a_glb_and_a_gltf_give_the_same_scene_z_up_with_made_normals() {
    let (from_glb, report) = read(&Gltf::square()).unwrap();
    let (from_gltf, _) = read_scene_bytes(&Gltf::square().gltf(), "a.gltf", &SceneReadOptions::default()).unwrap();
    assert_eq!(from_glb.meshes(), from_gltf.meshes(), "both containers");
    let mesh = &from_glb.meshes()[0];
    // (x, y, z)_lobe = (x, -z, y)_gltf: the square stands upright and faces -y.
    let expected = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]];
    assert_eq!(mesh.positions(), expected, "positions");
    assert_eq!(mesh.normals(), [[0.0, -1.0, 0.0]; 4], "normals");
    assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]], "triangles");
    assert_eq!(mesh.source(), Some(MeshSource { node: 0, mesh: 0, primitive: 0 }), "source");
    let mut expected = SceneReadReport::default();
    (expected.meshes, expected.vertices, expected.triangles, expected.made_normals) = (1, 4, 2, 4);
    assert_eq!(report, expected, "report");
}

#[test]
fn nodes_move_turn_and_scale_their_meshes_and_instances_become_meshes() {
    let half = 0.5_f32.sqrt();
    let file = Gltf::square()
        .with_attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4))
        .with("/scenes/0/nodes", json!([1]))
        .with("/nodes/1", json!({"children": [0, 2], "translation": [10.0, 0.0, 0.0]}))
        // A quarter turn about y takes +x to -z and +z to +x, after a scale by 2 along x.
        .with("/nodes/2", json!({"mesh": 0, "rotation": [0.0, half, 0.0, half], "scale": [2.0, 1.0, 1.0]}));
    let scene = scene(&file);
    assert_eq!(scene.meshes().len(), 2, "two instances");
    assert_eq!(scene.origin(), [10.0, 0.0, 0.0], "ten sizes away, positions count from the node that moved them");
    let first = &scene.meshes()[0];
    assert_eq!(first.positions()[2], [1.0, 0.0, 1.0], "moved");
    let turned = &scene.meshes()[1];
    assert_eq!(turned.source().map(|source| source.node), Some(2), "shown by node 2");
    let close = |a: [f32; 3], b: [f32; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6);
    // (1, 1, 0) -> (2, 1, 0) -> (0, 1, -2) -> (10, 1, -2) in the file, (10, 2, 1) in the world.
    assert!(close(turned.positions()[2], [0.0, 2.0, 1.0]), "{:?}", turned.positions()[2]);
    assert!(close(turned.normals()[2], [1.0, 0.0, 0.0]), "{:?}", turned.normals()[2]);
}

#[test]
fn mirrored_nodes_keep_their_outside() {
    let file = Gltf::square().with("/nodes/0/scale", json!([-1.0, 1.0, 1.0]));
    let scene_of_mirror = scene(&file);
    let mesh = &scene_of_mirror.meshes()[0];
    assert_eq!(mesh.positions()[1], [-1.0, 0.0, 0.0], "mirrored");
    assert_eq!(mesh.triangles()[0], [0, 2, 1], "corners run around the other way");
    assert_eq!(mesh.normals()[0], [0.0, -1.0, 0.0], "the outside stays outside");
    // The same by a matrix, by columns.
    let mut matrix = [0.0; 16];
    [matrix[0], matrix[5], matrix[10], matrix[15]] = [-1.0, 1.0, 1.0, 1.0];
    let by_matrix = Gltf::square().with("/nodes/0/matrix", json!(matrix));
    assert_eq!(scene(&by_matrix).meshes()[0], *mesh, "by a matrix");
}

#[test]
fn materials_vertex_colors_and_textures_are_read() {
    let png = Texture::new(2, 1, vec![[255, 0, 0, 255], [0, 255, 0, 0]], [Wrap::Repeat; 2]).to_png();
    let uri = format!("data:image/png;base64,{}", crate::common::base64(&png));
    let file = Gltf::square()
        .with_attribute("COLOR_0", "VEC3", &[0.5, 1.0, 1.0].repeat(4))
        .with_attribute("TEXCOORD_1", "VEC2", &[0.25, 0.5, 0.75, 0.5, 0.75, 0.5, 0.25, 0.5])
        .with("/meshes/0/primitives/0/material", json!(0))
        .with(
            "/materials",
            json!([{
                "name": "paint", "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
                "emissiveFactor": [1.0, 0.0, 0.0],
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.5, 0.5, 0.5, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.7,
                    "baseColorTexture": {"index": 0, "texCoord": 1},
                },
            }]),
        )
        .with("/textures", json!([{"source": 0, "sampler": 0}]))
        .with("/samplers", json!([{"wrapS": 33071, "wrapT": 33648}]))
        .with("/images", json!([{"uri": uri}]));
    let (scene, report) = read(&file).unwrap();
    let material = scene.material(0);
    assert_eq!((material.alpha, material.double_sided), (Alpha::Mask(0.25), true), "sides and alpha");
    assert_eq!((material.metallic, material.roughness, material.emissive), (0.0, 0.7, [1.0, 0.0, 0.0]), "factors");
    assert_eq!(scene.vertex_base_color(0, 0), [0.25, 0.0, 0.0, 1.0], "red texel x gray x vertex color");
    assert_eq!(scene.vertex_base_color(0, 1), [0.0, 0.5, 0.0, 0.0], "green texel");
    let note = "material `paint` is emissive, which is not used: light comes from the environment";
    assert_eq!(report.notes, [note], "notes");
}

#[test]
fn duplicates_and_unused_vertices_stay_and_triangles_without_area_are_counted() {
    let indices: [u16; 6] = [0, 1, 2, 1, 1, 3];
    let mut file = Gltf::square();
    file.buffer.splice(48..60, indices.iter().flat_map(|i| i.to_le_bytes()));
    let (scene, report) = read(&file).unwrap();
    assert_eq!((report.vertices, report.triangles, report.dropped_triangles), (4, 1, 1), "counts");
    assert_eq!(scene.meshes()[0].positions().len(), 4, "vertex 3 is not used any more");
}

#[test]
fn sparse_accessors_and_quantized_positions_are_read() {
    // Vertex 2 is replaced by (5, 6, 7).
    let mut file = Gltf::square();
    file.buffer.extend([2, 0, 0, 0]);
    file.buffer.extend([5.0_f32, 6.0, 7.0].iter().flat_map(|c| c.to_le_bytes()));
    let file = file
        .with("/buffers/0/byteLength", json!(76))
        .with("/bufferViews/2", json!({"buffer": 0, "byteOffset": 60, "byteLength": 2}))
        .with("/bufferViews/3", json!({"buffer": 0, "byteOffset": 64, "byteLength": 12}))
        .with(
            "/accessors/0/sparse",
            json!({"count": 1, "indices": {"bufferView": 2, "componentType": 5123}, "values": {"bufferView": 3}}),
        );
    assert_eq!(scene(&file).meshes()[0].positions()[2], [5.0, -7.0, 6.0], "replaced, z up");

    let bytes: [i8; 16] = [0, 0, 0, 0, 127, 0, 0, 0, 127, -128, 0, 0, 0, 127, 64, 0];
    let mut file = Gltf::square()
        .with("/extensionsUsed", json!(["KHR_mesh_quantization"]))
        .with("/extensionsRequired", json!(["KHR_mesh_quantization"]))
        .with(
            "/accessors/0",
            json!({"bufferView": 0, "componentType": 5120, "normalized": true, "count": 4, "type": "VEC3"}),
        )
        .with("/bufferViews/0", json!({"buffer": 0, "byteLength": 16, "byteStride": 4}));
    file.buffer.splice(0..16, bytes.iter().map(|b| b.cast_unsigned()));
    let expected = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, -1.0], [0.0, -64.0 / 127.0, 1.0]];
    assert_eq!(scene(&file).meshes()[0].positions()[..4], expected, "bytes are fractions of 127, z up");
}

fn refusal(file: &Gltf) -> SceneError {
    match read(file) {
        Err(error) => error,
        Ok((_, report)) => panic!("read as {report:?}"),
    }
}

/// Asserts that each file is refused as invalid, in these words.
fn assert_refused<const N: usize>(cases: [(Gltf, String); N]) {
    for (file, expected) in cases {
        let error = refusal(&file);
        assert_eq!(error.to_string(), expected, "message");
        assert!(matches!(error, SceneError::Invalid { .. }), "{error:?} is the file's fault");
    }
}

#[test]
fn numbers_that_are_not_in_their_buffers_are_refused_in_one_line() {
    let square = Gltf::square;
    let nan = [0.0_f32, f32::NAN, 0.0];
    let mut broken = square();
    broken.buffer.splice(12..24, nan.iter().flat_map(|c| c.to_le_bytes()));
    let view = "a.glb: mesh `square`, primitive 0: accessor 1: ";
    assert_refused([
        (broken, "a.glb: mesh `square`: expected finite positions, found [NaN, NaN, NaN] at vertex 1".to_string()),
        (square().with("/buffers/0/byteLength", json!(61)), "a.glb: expected 61 bytes in buffer 0, found 60".into()),
        (
            square().with("/accessors/1/count", json!(3_000_000_000_u32)),
            format!("{view}3000000000 elements do not fit into a buffer view of 12 bytes"),
        ),
        (
            square().with("/accessors/1/count", json!(u64::MAX)),
            format!("{view}18446744073709551615 elements do not fit into a buffer view of 12 bytes"),
        ),
        (
            square().with("/bufferViews/1/byteLength", json!(13)),
            format!("{view}buffer view 1 of 13 bytes from 48 does not fit into 60 bytes"),
        ),
        (
            square().with("/bufferViews/1/byteOffset", json!(u64::MAX)),
            format!("{view}buffer view 1 of 12 bytes from 18446744073709551615 does not fit into 60 bytes"),
        ),
        (
            square().with("/bufferViews/0/byteStride", json!(0)),
            "a.glb: mesh `square`, primitive 0: accessor 0: elements of 12 bytes stand only 0 apart".into(),
        ),
        (
            square().with("/accessors/1/componentType", json!(5126)),
            format!("{view}6 elements do not fit into a buffer view of 12 bytes"),
        ),
        (
            square().with("/accessors/0/type", json!("VEC2")),
            "a.glb: mesh `square`, primitive 0: expected vectors of 3 floats as POSITION, found 2 x F32".into(),
        ),
        (
            square().with("/accessors/1/componentType", json!(5122)),
            "a.glb: mesh `square`, primitive 0: expected unsigned whole numbers as indices, found 1 x I16".into(),
        ),
        (
            square().with("/accessors/0/count", json!(3)),
            "a.glb: mesh `square`: triangle 1 uses vertex 3, but there are 3 vertices".into(),
        ),
        (
            square().with("/accessors/1/count", json!(5)),
            "a.glb: mesh `square`, primitive 0: expected three indices for each triangle, found 5".into(),
        ),
    ]);
}

#[test]
fn files_that_contradict_themselves_are_refused_in_one_line() {
    let square = Gltf::square;
    assert_refused([
        (
            square().with("/meshes/0/primitives/0/attributes/POSITION", json!(9)),
            "a.glb: mesh `square`, primitive 0: uses accessor 9, but there are 2".into(),
        ),
        (
            square().with("/meshes/0/primitives/0/attributes", json!({})),
            "a.glb: mesh `square`, primitive 0: has no POSITION".into(),
        ),
        (square().with("/nodes/0/mesh", json!(7)), "a.glb: node 0 shows mesh 7, but there are 1".into()),
        (square().with("/scenes/0/nodes", json!([4])), "a.glb: names node 4, but there are 1".into()),
        (square().with("/scene", json!(3)), "a.glb: shows scene 3, but there are 1".into()),
        (square().with("/nodes/0/children", json!([0])), "a.glb: node 0 is its own ancestor or has two parents".into()),
        (
            square().with("/meshes/0/primitives/0/material", json!(0)),
            "a.glb: scene: mesh `square` is of material 0, but there are 0".into(),
        ),
        (square().with("/nodes", json!([{}])), "a.glb: expected triangles, found none".into()),
        (square().with("/meshes/0/primitives", json!([])), "a.glb: expected triangles, found none".into()),
        (square().with("/accessors/1/count", json!(0)), "a.glb: expected triangles, found none".into()),
        (
            square().with("/nodes/0/scale", json!([0.0, 1.0, 1.0])),
            "a.glb: expected triangles with an area, found 2 without".into(),
        ),
    ]);
}

#[test]
fn a_million_triangles_without_area_are_refused_and_nothing_hangs() {
    let mut file = Gltf::square();
    file.buffer.truncate(48);
    file.buffer.resize(48 + 6_000_000, 0);
    let file = file
        .with("/buffers/0/byteLength", json!(6_000_048))
        .with("/bufferViews/1/byteLength", json!(6_000_000))
        .with("/accessors/1/count", json!(3_000_000));
    let found = refusal(&file).to_string();
    assert_eq!(found, "a.glb: expected triangles with an area, found 1000000 without", "message");
}

#[test]
fn files_that_are_cut_off_or_no_gltf_are_refused() {
    let whole = Gltf::square().glb();
    for length in 0..whole.len() - 1 {
        let found = read_scene_bytes(&whole[..length], "a.glb", &SceneReadOptions::default());
        assert!(matches!(found, Err(SceneError::Invalid { .. })), "{length} bytes: {found:?}");
    }
    for bytes in [&b"{}"[..], b"", b"[]", b"{\"asset\": {\"version\": 2}}", b"\xFF\xFE"] {
        let error = read_scene_bytes(bytes, "a.gltf", &SceneReadOptions::default()).unwrap_err().to_string();
        let is_json = bytes.starts_with(b"{");
        let said =
            if is_json { "found an error: " } else { "which begins with `glTF` or is JSON, found something else" };
        assert!(error.starts_with(&format!("a.gltf: expected glTF, {said}")) && !error.contains('\n'), "{error}");
    }
}

#[test]
fn what_lobe_does_not_read_is_named_with_what_to_do() {
    let requiring = |name: &str| Gltf::square().with("/extensionsRequired", json!([name]));
    for (file, expected) in [
        (
            requiring("EXT_texture_avif"),
            "a.glb: the file requires EXT_texture_avif, which Lobe does not read: convert its textures with \
             `gltf-transform png IN OUT`",
        ),
        (requiring("ACME_voxels"), "a.glb: the file requires ACME_voxels, which Lobe does not read: export it without"),
        (Gltf::square().with("/asset/version", json!("1.0")), "a.glb: expected version 2.0 of glTF, found 1.0"),
        (
            Gltf::square().with("/buffers/0/uri", json!("https://example.org/a.bin")),
            "a.glb: names `https://example.org/a.bin`: Lobe reads files only, so fetch it first",
        ),
        (
            Gltf::square().with("/buffers/0/uri", json!("a.bin")),
            "a.glb: names the file `a.bin`, but only bytes were given: read the file",
        ),
    ] {
        let error = refusal(&file);
        assert_eq!(error.to_string(), expected, "message");
        assert!(matches!(error, SceneError::Unsupported { .. }), "{error:?} may be right elsewhere");
    }
}

#[test]
fn a_scene_is_read_whatever_others_have_put_into_its_extras() {
    for extras in [json!({"lobe": {"version": 99}}), json!({"lobe": "bright"}), json!([1])] {
        let (scene, _) = read(&Gltf::square().with("/asset", json!({"version": "2.0", "extras": extras}))).unwrap();
        assert_eq!(scene.triangle_count(), 2, "{extras}");
    }
}

#[test]
fn a_small_file_that_unfolds_to_too_much_is_refused_before_memory_is_taken() {
    let nodes: Vec<_> = (0..100).map(|_| json!({"mesh": 0})).collect();
    let file = Gltf::square().with("/nodes", json!(nodes)).with("/scenes/0/nodes", json!((0..100).collect::<Vec<_>>()));
    let options = SceneReadOptions::default().max_triangles(250);
    let error = read_scene_bytes(&file.glb(), "a.glb", &options).unwrap_err();
    let expected = "a.glb: expected at most 250 triangles and vertices, found 126 and 252 or more: raise SceneReadOptions::max_triangles";
    assert_eq!(error.to_string(), expected, "message");
    assert!(matches!(error, SceneError::Refused { .. }), "{error:?}");
    assert_eq!(scene(&file).meshes().len(), 100, "within the usual limit it is read");
}

/// A PNG of one color as a `data:` URI.
fn png(width: usize, height: usize) -> String {
    let white = vec![[255; 4]; width * height];
    let png = Texture::new(width, height, white, [Wrap::Repeat; 2]).to_png();
    format!("data:image/png;base64,{}", crate::common::base64(&png))
}

#[test]
fn a_picture_named_by_many_textures_is_kept_once_and_large_ones_are_refused_before_they_are_decoded() {
    let materials: Vec<_> =
        (0..12).map(|k| json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": k}}})).collect();
    let primitives: Vec<_> =
        (0..12).map(|k| json!({"attributes": {"POSITION": 0}, "indices": 1, "material": k})).collect();
    let file = Gltf::square()
        .with("/meshes/0/primitives", json!(primitives))
        .with("/materials", json!(materials))
        .with("/textures", json!(vec![json!({"source": 0}); 12]))
        .with("/images", json!([{"uri": png(40, 30)}]));
    assert_eq!(scene(&file).textures().len(), 1, "one picture, twelve textures");
    let options = SceneReadOptions::default().max_texels(1199);
    let error = read_scene_bytes(&file.glb(), "a.glb", &options).unwrap_err();
    let expected =
        "a.glb: expected textures of at most 1199 texels, found 1200 or more: raise SceneReadOptions::max_texels";
    assert_eq!(error.to_string(), expected, "message");
    let nowhere = file.with("/images", json!([{"name": "lost"}]));
    let error = read_scene_bytes(&nowhere.glb(), "a.glb", &SceneReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("image 0 has neither a URI nor a buffer view: export the scene again"), "{error}");
}

#[test]
fn glass_and_blended_materials_let_light_through_if_asked_to_and_are_noted_if_not() {
    let glass = json!({"name": "pane", "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.75}}});
    let foil = json!({"name": "foil", "alphaMode": "BLEND"});
    let file = Gltf::square()
        .with("/materials", json!([glass, foil]))
        .with("/extensionsUsed", json!(["KHR_materials_transmission"]));
    for is_asked in [false, true] {
        let options = SceneReadOptions::default().straight_through(is_asked);
        let (scene, report) = read_scene_bytes(&file.glb(), "a.glb", &options).unwrap();
        let notes =
            ["material `pane` is glass, and taken as opaque", "material `foil` is blended, and taken as opaque"];
        assert_eq!(report.notes, if is_asked { vec![] } else { notes.map(String::from).to_vec() }, "notes");
        let found: Vec<_> = scene.materials().iter().map(|m| (m.transmission, m.has_holes())).collect();
        assert_eq!(found, [(0.75, is_asked), (0.0, is_asked)], "transmission, and whether light passes");
    }
}

#[test]
fn the_attenuation_of_a_volume_is_named_where_light_goes_through_it() {
    let glass = json!({"transmissionFactor": 1.0});
    let volume = json!({"thicknessFactor": 1.0, "attenuationDistance": 0.5});
    let extensions = json!({"KHR_materials_transmission": glass, "KHR_materials_volume": volume});
    let file = Gltf::square().with("/materials", json!([{"name": "jar", "extensions": extensions}]));
    let options = SceneReadOptions::default().straight_through(true);
    let (_, report) = read_scene_bytes(&file.glb(), "a.glb", &options).unwrap();
    let expected =
        "material `jar` has a volume, whose attenuation is not used: glass tints light at its surfaces alone";
    assert_eq!(report.notes, [expected], "notes");
}

#[test]
fn instances_count_against_the_limit_of_memory_before_they_are_read() {
    // Two triangles and four vertices, many times.
    let count = 200_000;
    let nodes = vec![json!({"mesh": 0}); count];
    let scenes = json!([{"nodes": (0..count).collect::<Vec<_>>()}]);
    let file = Gltf::square().with("/nodes", json!(nodes)).with("/scenes", scenes);
    let options = SceneReadOptions::default().max_bytes(1 << 20);
    let error = read_scene_bytes(&file.glb(), "a.glb", &options).unwrap_err().to_string();
    assert!(error.starts_with("a.glb: expected a scene of at most 1048576 bytes, found "), "{error}");
    assert!(error.ends_with("raise SceneReadOptions::max_bytes"), "{error}");
}

#[test]
fn factors_and_colors_outside_of_their_range_are_moved_into_it_and_noted() {
    let color = [1.0, 1.0, 2.0, 1.0].repeat(4);
    let file = Gltf::square().with_attribute("COLOR_0", "VEC4", &color).with(
        "/materials",
        json!([{"name": "m", "pbrMetallicRoughness": {
            "baseColorFactor": [-1.0, 0.5, 1.0, 1.0], "metallicFactor": 5.0, "roughnessFactor": -3.0,
        }}]),
    );
    let (scene, report) = read(&file.with("/meshes/0/primitives/0/material", json!(0))).unwrap();
    let material = scene.material(0);
    assert_eq!((material.metallic, material.roughness), (1.0, 0.0), "factors");
    assert_eq!(scene.vertex_base_color(0, 0), [0.0, 0.5, 1.0, 1.0], "color");
    assert_eq!(
        report.notes,
        [
            "material `m`: a base color factor of -1 is outside of 0 to 1, and taken as 0",
            "material `m`: a metallic factor of 5 is outside of 0 to 1, and taken as 1",
            "material `m`: a roughness factor of -3 is outside of 0 to 1, and taken as 0",
            "mesh `square` has colors outside of 0 to 1 at 4 vertices, moved there",
        ],
        "notes"
    );
}

#[test]
fn colors_kept_in_an_extension_are_noted_and_refused_where_they_are_required() {
    let name = "KHR_materials_pbrSpecularGlossiness";
    let used = Gltf::square().with("/extensionsUsed", json!([name]));
    let (_, report) = read(&used).unwrap();
    let note = format!("{name} is not used, colors may be missing: convert to metallic-roughness");
    assert_eq!(report.notes, [note], "notes");
    let error = refusal(&used.with("/extensionsRequired", json!([name]))).to_string();
    assert!(error.ends_with("convert its materials with `gltf-transform metalrough IN OUT`"), "{error}");
}

#[cfg(unix)]
#[test]
fn devices_named_as_buffers_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    fs::write(&path, Gltf::square().with("/buffers/0/uri", json!("/dev/zero")).json.to_string()).unwrap();
    let error = read_scene(&path, &SceneReadOptions::default().allow_outside(true)).unwrap_err();
    assert!(error.to_string().contains("found a device or a pipe"), "{error}");
}

#[test]
fn buffers_and_textures_beside_the_file_are_found_and_missing_ones_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    let file = Gltf::square().with("/buffers/0/uri", json!("my%20buffer.bin"));
    fs::write(&path, file.json.to_string()).unwrap();
    let error = read_scene(&path, &SceneReadOptions::default()).unwrap_err();
    assert!(matches!(error, SceneError::Io { .. }), "{error:?}");
    assert!(error.to_string().contains("my buffer.bin, named by"), "{error}");
    fs::write(folder.path().join("my buffer.bin"), &file.buffer).unwrap();
    let (read, _) = read_scene(&path, &SceneReadOptions::default()).unwrap();
    assert_eq!(read.meshes(), scene(&Gltf::square()).meshes(), "the same as from a .glb");
}

#[test]
fn a_real_file_is_read() {
    let suzi = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/suzi.glb");
    let (_, report) = read_scene(&suzi, &SceneReadOptions::default()).unwrap();
    let found = (report.vertices, report.triangles + report.dropped_triangles);
    assert_eq!(found, (7503, 14842), "vertices and triangles of suzi.glb; {report:?}");
}

#[test]
fn members_that_are_not_used_need_not_be_right_and_empty_scenes_need_no_nodes() {
    // A scene without nodes beside the one that is shown; an animation of an extension, which targets no node.
    let file = Gltf::square()
        .with("/scenes/1", json!({"name": "empty"}))
        .with("/animations", json!([{"channels": [{"sampler": 0, "target": {"path": "pointer"}}], "samplers": [{}]}]))
        .with("/cameras", json!([{"type": "fisheye"}]));
    let (scene, report) = read(&file).unwrap();
    assert_eq!(scene.triangle_count(), 2, "the scene");
    assert_eq!(report.notes, ["animation 0 animates a pointer, which is not used"], "notes");
    let empty = refusal(&file.with("/scene", json!(1))).to_string();
    assert_eq!(empty, "a.glb: expected triangles, found none", "the empty scene");
}

#[test]
fn an_error_names_its_member() {
    let error = refusal(&Gltf::square().with("/nodes/0/mesh", json!("first"))).to_string();
    assert!(error.starts_with("a.glb: expected glTF, found an error at nodes[0].mesh: "), "{error}");
}

#[test]
fn accessors_without_a_buffer_view_are_zeros() {
    let mut file = Gltf::square().with_attribute("COLOR_0", "VEC4", &[0.5; 16]);
    file.json["accessors"][2].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(scene(&file).meshes()[0].colors(), [[0.0; 4]; 4], "colors");
    let many = file.with("/accessors/2/count", json!(1_u64 << 60));
    assert!(matches!(refusal(&many), SceneError::Refused { .. }), "no memory is taken");
}

#[test]
fn names_with_line_ends_and_control_characters_stay_in_one_line() {
    let named = Gltf::square().with("/meshes/0/name", json!("a\nb\u{1b}[2J"));
    let found = refusal(&named.with("/accessors/0/count", json!(3))).to_string();
    assert_eq!(found, "a.glb: mesh `a b [2J`: triangle 1 uses vertex 3, but there are 3 vertices", "an error");
    let (_, report) = read(&named_points()).unwrap();
    assert_eq!(report.notes, ["mesh `a b`, primitive 1 has points or lines and was left out"], "a note");
}

fn named_points() -> Gltf {
    let points = json!({"attributes": {"POSITION": 0}, "mode": 0});
    Gltf::square().with("/meshes/0/name", json!("a\nb")).with("/meshes/0/primitives/1", points)
}
