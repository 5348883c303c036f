//! What others compressed inside of a `.glb`, behind headers that are always whole: a stream of meshopt, a mesh of Draco, or a picture
//! (WebP, JPEG, PNG, KTX2 with Basis Universal).
//!
//! The first byte tells the kind; behind it stand, of meshopt, the mode, the filter, the bytes of an element and the number of elements.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_fuzz::{let_decoders_panic, refused_in_one_line};
use lobe_scene::{SceneReadOptions, read_scene_bytes};

/// Small enough that no input takes long, large enough that every path is reached.
const LIMIT: usize = 1 << 16;

/// Decoders may ask for this much at most.
const MAX_BYTES: u64 = 1 << 26;

/// A triangle: positions, texture coordinates.
const TRIANGLE: [f32; 15] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];

fuzz_target!(init: let_decoders_panic(), |bytes: &[u8]| {
    let file = match *bytes {
        [0, mode, filter, stride, count, ref payload @ ..] => meshopt([mode, filter], stride, count, payload),
        [1, ref payload @ ..] => draco(payload),
        [_, ref payload @ ..] => picture(payload),
        [] => return,
    };
    let options = SceneReadOptions::default().max_triangles(LIMIT).max_texels(LIMIT).max_bytes(MAX_BYTES);
    refused_in_one_line(read_scene_bytes(&file, "fuzz", &options));
});

/// A view that no accessor uses: it is decoded all the same.
fn meshopt([mode, filter]: [u8; 2], stride: u8, count: u8, payload: &[u8]) -> Vec<u8> {
    let mode = ["ATTRIBUTES", "TRIANGLES", "INDICES"][usize::from(mode) % 3];
    let filter = ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"][usize::from(filter) % 5];
    let (stride, count) = (usize::from(stride), usize::from(count));
    let view = format!(
        r#"{{"buffer":0,"byteLength":{},"extensions":{{"EXT_meshopt_compression":{{"buffer":0,"byteOffset":60,
            "byteLength":{},"byteStride":{stride},"count":{count},"mode":"{mode}","filter":"{filter}"}}}}}}"#,
        stride * count,
        payload.len()
    );
    glb(&[view], r#"{"attributes":{"POSITION":0}}"#, "", &[], payload)
}

fn draco(payload: &[u8]) -> Vec<u8> {
    let view = format!(r#"{{"buffer":0,"byteOffset":60,"byteLength":{}}}"#, payload.len());
    let primitive = r#"{"attributes":{"POSITION":2,"TEXCOORD_0":3},"indices":4,"extensions":{"KHR_draco_mesh_compression":
        {"bufferView":2,"attributes":{"POSITION":0,"TEXCOORD_0":1}}}}"#;
    let accessors = [
        r#"{"componentType":5126,"count":4,"type":"VEC3"}"#.to_owned(),
        r#"{"componentType":5126,"count":4,"type":"VEC2"}"#.to_owned(),
        r#"{"componentType":5123,"count":6,"type":"SCALAR"}"#.to_owned(),
    ];
    glb(&[view], primitive, "", &accessors, payload)
}

fn picture(payload: &[u8]) -> Vec<u8> {
    let view = format!(r#"{{"buffer":0,"byteOffset":60,"byteLength":{}}}"#, payload.len());
    let (kind, texture) = match payload {
        [b'R', ..] => ("image/webp", r#"{"extensions":{"EXT_texture_webp":{"source":0}}}"#),
        [0xab, ..] => ("image/ktx2", r#"{"extensions":{"KHR_texture_basisu":{"source":0}}}"#),
        [0xff, ..] => ("image/jpeg", r#"{"source":0}"#),
        _ => ("image/png", r#"{"source":0}"#),
    };
    let material = format!(
        r#""materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],"textures":[{texture}],
            "images":[{{"bufferView":2,"mimeType":"{kind}"}}],"#
    );
    let primitive = r#"{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}"#;
    glb(&[view], primitive, &material, &[], payload)
}

/// A binary glTF of a triangle and this payload behind it.
fn glb(views: &[String], primitive: &str, members: &str, accessors: &[String], payload: &[u8]) -> Vec<u8> {
    let mut buffer: Vec<u8> = TRIANGLE.iter().flat_map(|number| number.to_le_bytes()).collect();
    buffer.extend_from_slice(payload);
    let length = buffer.len();
    let joined = |items: &[String]| items.iter().map(|item| format!(",{item}")).collect::<String>();
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{primitive}]}}],{members}"accessors":[
        {{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
        {{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}}{}],"bufferViews":[
        {{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":24}}{}],
        "buffers":[{{"byteLength":{length}}}]}}"#,
        joined(accessors),
        joined(views)
    )
    .into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    buffer.resize(length.next_multiple_of(4), 0);
    let word = |number: usize| (number as u32).to_le_bytes();
    [
        b"glTF".as_slice(),
        &word(2),
        &word(12 + 8 + json.len() + 8 + buffer.len()),
        &word(json.len()),
        b"JSON",
        &json,
        &word(buffer.len()),
        b"BIN\0",
        &buffer,
    ]
    .concat()
}
