//! Textures and vertex data as the encoders write them that everybody uses, of files that `fixtures/make.mjs` made by them:
//! Basis Universal with its own supercompression and behind Zstandard, and the filters of meshopt.

use std::fs;

use lobe_scene::{GltfDocument, GltfReader, Scene, SceneReadOptions};
use serde_json::{Value, json};

use crate::common::{Gltf, base64};

const ETC1S: &[u8] = include_bytes!("fixtures/etc1s.ktx2");
const UASTC_ZSTANDARD: &[u8] = include_bytes!("fixtures/uastc_zstd.ktx2");
const FILTERS: &str = include_str!("fixtures/meshopt_filters.json");

/// The colors of the quarters, row by row.
const QUARTERS: [[u8; 3]; 4] = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [128, 128, 128]];

/// Steps of 255 by which a color may differ: ETC1S has colors of 5 bits, so steps of 8, of which half is off at most.
const COLOR_STEPS: f32 = 4.0;

fn read(file: &Gltf) -> (Scene, GltfDocument) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    fs::write(&path, file.glb()).unwrap();
    let reader = GltfReader::open(&path, &SceneReadOptions::default());
    let (scene, _, document) = reader.and_then(GltfReader::into_scene_and_document).unwrap();
    (scene, document)
}

#[test]
fn textures_behind_both_supercompressions_have_their_colors() {
    for (bytes, name) in [(ETC1S, "ETC1S"), (UASTC_ZSTANDARD, "UASTC behind Zstandard")] {
        let uri = format!("data:image/ktx2;base64,{}", base64(bytes));
        let centers = [0.25, 0.25, 0.75, 0.25, 0.25, 0.75, 0.75, 0.75];
        let file = Gltf::square()
            .with_attribute("TEXCOORD_0", "VEC2", &centers)
            .with("/meshes/0/primitives/0/material", json!(0))
            .with("/materials", json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]))
            .with("/textures", json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]))
            .with("/images", json!([{"uri": uri}]))
            .with("/samplers", json!([{"magFilter": 9728}]))
            .with("/textures/0/sampler", json!(0))
            .with("/extensionsRequired", json!(["KHR_texture_basisu"]));
        let (scene, _) = read(&file);
        for (vertex, expected) in QUARTERS.iter().enumerate() {
            let found = base_color(&scene, vertex);
            let nearest = expected.iter().zip(found).all(|(&e, f)| (f32::from(e) - f).abs() <= COLOR_STEPS);
            assert!(nearest, "{name}: quarter {vertex}: {found:?} for {expected:?}");
        }
    }
}

/// The base color at a vertex, in steps of 255 of its gamma-encoded form.
fn base_color(scene: &Scene, vertex: usize) -> [f32; 3] {
    let [red, green, blue, _] = scene.vertex_base_color(0, vertex);
    [red, green, blue].map(|c| {
        // The transfer function of sRGB, IEC 61966-2-1.
        let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        255.0 * encoded
    })
}

#[test]
fn vertex_data_behind_filters_of_meshopt_is_what_was_encoded() {
    let views: Vec<Value> = serde_json::from_str(FILTERS).unwrap();
    assert_eq!(views.len(), 4, "two octahedral, quaternions, exponents");
    for view in views {
        let bytes: Vec<u8> = serde_json::from_value(view["bytes"].clone()).unwrap();
        let values: Vec<Vec<f32>> = serde_json::from_value(view["values"].clone()).unwrap();
        let (filter, stride) = (view["filter"].as_str().unwrap(), view["stride"].as_u64().unwrap() as usize);
        let decoded = decoded(&bytes, filter, stride);
        for (element, expected) in decoded.chunks(stride).zip(&values) {
            let (found, step) = numbers(element, filter);
            // q and -q are the same turn.
            let signs: &[f32] = if filter == "QUATERNION" { &[1.0, -1.0] } else { &[1.0] };
            let is_near = signs
                .iter()
                .any(|sign| expected.iter().zip(&found).all(|(e, f)| (e - sign * f).abs() <= step * e.abs().max(1.0)));
            assert!(is_near, "{filter} of {stride} bytes: {found:?} for {expected:?}");
        }
    }
}

/// The plain bytes of a view, which a document of a file holds that has it beside those of a square.
fn decoded(bytes: &[u8], filter: &str, stride: usize) -> Vec<u8> {
    let name = "EXT_meshopt_compression";
    let mut file = Gltf::square();
    let (start, length) = (file.buffer.len(), 4 * stride);
    file.buffer.extend_from_slice(bytes);
    let compressed = json!({"buffer": 0, "byteOffset": start, "byteLength": bytes.len(), "byteStride": stride,
        "count": 4, "mode": "ATTRIBUTES", "filter": filter});
    let views = file.json["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 1, "byteLength": length, "byteStride": stride, "extensions": {name: compressed}}));
    let end = file.buffer.len();
    let fallback = json!({"byteLength": length, "extensions": {name: {"fallback": true}}});
    let file = file
        .with("/buffers", json!([{"byteLength": end}, fallback]))
        .with("/extensionsUsed", json!([name]))
        .with("/extensionsRequired", json!([name]));
    let (_, document) = read(&file);
    let view = &document.json["bufferViews"][2];
    let offset = view["byteOffset"].as_u64().unwrap_or(0) as usize;
    document.bytes[offset..offset + length].to_vec()
}

/// The numbers of an element, and the step in which they are stored, relative to numbers above 1. The formats are those that the
/// extension gives each filter: normalized bytes or words, or floats of which 15 bits were kept.
fn numbers(element: &[u8], filter: &str) -> (Vec<f32>, f32) {
    match (filter, element.len()) {
        ("EXPONENTIAL", _) => {
            (element.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect(), 1.0 / 16384.0)
        }
        // Octahedral coordinates turn by up to the square root of 3 of their step.
        (_, 4) => (element[..3].iter().map(|&byte| f32::from(byte as i8) / 127.0).collect(), 2.0 / 127.0),
        _ => {
            let words = element.as_chunks().0.iter().map(|bytes| f32::from(i16::from_le_bytes(*bytes)) / 32767.0);
            (words.collect(), 2.0 / 32767.0)
        }
    }
}
