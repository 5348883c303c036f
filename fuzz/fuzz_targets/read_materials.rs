//! Materials of a Wavefront scene: the bytes are those of its .mtl, which lies beside it.
#![no_main]

use std::path::PathBuf;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use lobe_scene::{SceneReadOptions, read_scene};

/// The name of the materials.
const MATERIALS: &str = "fuzz.mtl";

/// A scene of one triangle of each of two materials, in a folder of this process.
static SCENE: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = std::env::temp_dir().join(format!("lobe-fuzz-materials-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("the folder of temporary files can be written");
    let scene = folder.join("fuzz.obj");
    let text = format!("mtllib {MATERIALS}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 3 2 1\n");
    std::fs::write(&scene, text).expect("the folder can be written");
    scene
});

fuzz_target!(|bytes: &[u8]| {
    std::fs::write(SCENE.with_file_name(MATERIALS), bytes).expect("the folder can be written");
    match read_scene(&*SCENE, &SceneReadOptions::default()) {
        Ok((scene, report)) => {
            assert!(scene.triangle_count() == 2, "a material changes no triangle");
            let notes = report.remarks();
            assert!(notes.iter().all(|note| !note.contains('\n')), "{notes:?}");
        }
        Err(error) => {
            let line = error.to_string();
            assert!(!line.contains('\n'), "{line:?}");
        }
    }
});
