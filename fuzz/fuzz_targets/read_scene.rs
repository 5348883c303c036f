//! A scene of any format, told by its first bytes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_scene::{MissingNormals, SceneReadOptions, read_scene_bytes};

/// Small enough that no input takes long, large enough that every path is reached.
const LIMIT: usize = 1 << 16;

fuzz_target!(init: lobe_fuzz::let_decoders_panic(), |bytes: &[u8]| {
    let name = match bytes {
        [b'g', b'l', b'T', b'F', ..] => "fuzz.glb",
        [b'{', ..] => "fuzz.gltf",
        [b'p', b'l', b'y', ..] => "fuzz.ply",
        _ => "fuzz.obj",
    };
    for normals in [MissingNormals::AsFormat, MissingNormals::Flat] {
        let options = SceneReadOptions::default().max_triangles(LIMIT).max_texels(LIMIT).missing_normals(normals);
        match read_scene_bytes(bytes, name, &options) {
            Ok((scene, _)) => {
                let finite = |points: &[[f32; 3]]| points.as_flattened().iter().all(|c| c.is_finite());
                assert!(scene.triangle_count() > 0, "a scene has triangles");
                assert!(scene.meshes().iter().all(|mesh| finite(mesh.positions())), "a position is not finite");
                assert!(scene.meshes().iter().all(|mesh| finite(mesh.normals())), "a normal is not finite");
            }
            Err(error) => {
                let line = error.to_string();
                assert!(line.starts_with(name) && !line.contains('\n'), "{line:?}");
            }
        }
    }
});
