//! Damaged files: an error or a scene, no panic and no unbounded memory.

use crate::common::Gltf;
use lobe_scene::{SceneReadOptions, read_scene_bytes};
use lobe_testkit::Random;

const OBJ: &str = "o thing\nv 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 0 1 0\nv 0 1 0 0 0 1\nvt 0 0\nvt 1 0.5\nvn 0 0 1\n\
     g part\nusemtl red\ns 1\nf 1/1/1 2/2/1 3/1/1 4/2/1\nf -4 -3 -2\nl 1 2\np 3\n";

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty double y\nproperty float z\n\
     property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\nproperty list uchar int vertex_indices\n\
     end_header\n0 0 0 255 0 0\n1 0 0 255 0 0\n1 1 0 255 255 0\n3 0 1 2\n";

/// Replaces, inserts, doubles or removes a few bytes.
fn damaged(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + random.next_u64() % 4 {
        if bytes.is_empty() {
            break;
        }
        let at = (random.next_u64() % bytes.len() as u64) as usize;
        match random.next_u64() % 5 {
            0 => bytes[at] = random.next_u64() as u8,
            1 => bytes[at] = b"0123456789-/ .e\n"[(random.next_u64() % 16) as usize],
            2 => bytes.insert(at, b'9'),
            3 => {
                bytes.remove(at);
            }
            _ => bytes.truncate(at),
        }
    }
    bytes
}

#[test]
fn damaged_files_give_a_scene_or_one_line() {
    let glb = Gltf::square().with_attribute("COLOR_0", "VEC4", &[0.5; 16]).glb();
    let gltf = Gltf::square().gltf();
    let options = SceneReadOptions::default().max_triangles(1 << 20);
    let mut random = Random::new(12);
    let (mut read, mut refused) = (0, 0);
    for (name, bytes) in [("a.glb", &glb[..]), ("a.gltf", &gltf), ("a.obj", OBJ.as_bytes()), ("a.ply", PLY.as_bytes())]
    {
        let whole = read_scene_bytes(bytes, name, &options);
        assert!(whole.is_ok(), "{name} as it should be: {whole:?}");
        for _ in 0..3000 {
            let bytes = damaged(bytes, &mut random);
            match read_scene_bytes(&bytes, name, &options) {
                Ok((scene, _)) => {
                    assert!(scene.triangle_count() > 0, "{name}: a scene has triangles");
                    read += 1;
                }
                Err(error) => {
                    let message = error.to_string();
                    assert!(!message.contains('\n') && message.starts_with("a."), "{name}: {message:?}");
                    refused += 1;
                }
            }
        }
    }
    assert!(read > 300 && refused > 1000, "{read} read and {refused} refused: a test of both");
}
