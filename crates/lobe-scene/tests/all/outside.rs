//! Files that a scene names lie in its folder: nothing outside of it is read, let alone copied.

use std::fs;
use std::path::PathBuf;

use lobe_scene::{GltfReader, SceneError, SceneReadOptions, SceneReadReport, read_scene};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::common::Gltf;

const SECRET: &[u8] = b"sixty bytes that nobody but their owner should ever see...!!";

/// A folder with a secret in it, and a folder of a scene in that.
struct Place {
    root: TempDir,
}

impl Place {
    fn new() -> Self {
        let root = tempfile::tempdir().unwrap();
        fs::create_dir(root.path().join("scene")).unwrap();
        fs::write(root.path().join("secret"), SECRET).unwrap();
        Self { root }
    }

    fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.root.path().join("scene").join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, bytes).unwrap();
        path
    }

    /// Every way to name the secret from within the folder of the scene.
    fn attacks(&self) -> Vec<String> {
        self.file("deep/down/here", b"");
        let mut attacks = vec![
            self.root.path().join("secret").display().to_string(),
            "../secret".into(),
            "deep/../../secret".into(),
            "./deep/down/../../../secret".into(),
            "../scene/../secret".into(),
        ];
        #[cfg(unix)]
        {
            let link = |target: PathBuf, name: &str| {
                std::os::unix::fs::symlink(target, self.root.path().join("scene").join(name)).unwrap();
            };
            link(self.root.path().join("secret"), "file-link");
            link("../secret".into(), "relative-link");
            link(self.root.path().to_path_buf(), "folder-link");
            attacks.extend(["file-link", "relative-link", "folder-link/secret"].map(String::from));
        }
        attacks
    }
}

fn assert_outside<T: std::fmt::Debug>(found: Result<T, SceneError>, name: &str) {
    let error = found.unwrap_err();
    let expected = format!("names the file `{name}`, which is outside of its folder: move it there, or trust the file");
    assert!(
        error.to_string().contains(&expected) && matches!(error, SceneError::Unsupported { .. }),
        "{name}: {error}"
    );
}

fn has_secret(bytes: &[u8]) -> bool {
    bytes.windows(20).any(|part| SECRET.starts_with(part))
}

#[test]
fn buffers_outside_of_the_folder_are_refused_unless_the_file_is_trusted() {
    let place = Place::new();
    for name in place.attacks() {
        // As an attacker writes it: the two spellings of a URI.
        for uri in [name.clone(), name.replace("..", "%2e%2E").replace('/', "%2F")] {
            let file = Gltf::square().with("/buffers/0/uri", json!(uri));
            let path = place.file("a.gltf", file.json.to_string());
            assert_outside(read_scene(&path, &SceneReadOptions::default()), &name);
            assert_outside(
                GltfReader::open(&path, &SceneReadOptions::default()).and_then(GltfReader::into_scene_and_document),
                &name,
            );
            // Read as the secret, the square is no scene; but it is read.
            let trusted = SceneReadOptions::default().allow_outside(true);
            let read = read_scene(&path, &trusted).map_err(|error| error.to_string());
            assert!(!format!("{read:?}").contains("outside"), "{uri}: {read:?}");
        }
    }
}

#[test]
fn buffers_that_nothing_uses_are_not_read_and_not_copied() {
    let place = Place::new();
    place.file("beside", SECRET);
    for name in place.attacks().into_iter().chain(["beside".to_string(), "missing".to_string()]) {
        for options in [SceneReadOptions::default(), SceneReadOptions::default().allow_outside(true)] {
            let file = Gltf::square().with("/buffers/1", json!({"uri": name, "byteLength": 4}));
            let path = place.file("a.glb", file.glb());
            let (scene, report, document) =
                GltfReader::open(&path, &options).and_then(GltfReader::into_scene_and_document).unwrap();
            assert_eq!(scene.triangle_count(), 2, "{name}: the scene is read");
            assert_eq!(report.notes, ["buffer 1 is not used, and was not read"], "{name}");
            assert!(!has_secret(&document.bytes), "{name} was copied");
        }
    }
}

#[test]
fn pictures_outside_of_the_folder_are_refused_where_they_are_used_and_never_copied() {
    let place = Place::new();
    for name in place.attacks() {
        let textured = Gltf::square()
            .with("/meshes/0/primitives/0/material", json!(0))
            .with("/images", json!([{"uri": name}]))
            .with("/textures", json!([{"source": 0}]))
            .with("/materials", json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]));
        let path = place.file("a.glb", textured.glb());
        assert_outside(read_scene(&path, &SceneReadOptions::default()), &name);
        // A picture that the scene does not use stays a name.
        let unused = textured.with("/meshes/0/primitives/0/material", json!(null));
        let path = place.file("a.glb", unused.glb());
        let (_, report, document) = GltfReader::open(&path, &SceneReadOptions::default())
            .and_then(GltfReader::into_scene_and_document)
            .unwrap();
        assert!(notes_outside(&report), "{name}: {:?}", report.notes);
        assert!(!has_secret(&document.bytes), "{name} was copied");
        assert_eq!(document.json["images"][0], json!({"uri": name}), "{name}: kept as it was");
    }
}

fn notes_outside(report: &SceneReadReport) -> bool {
    report.notes.iter().any(|note| note.contains("which is outside of its folder"))
}

#[test]
fn materials_and_textures_of_an_obj_stay_in_the_folder() {
    let place = Place::new();
    let triangle = "v 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl m\nf 1 2 3\n";
    for name in place.attacks() {
        let path = place.file("a.obj", format!("mtllib {name}\n{triangle}"));
        let (_, report) = read_scene(&path, &SceneReadOptions::default()).unwrap();
        assert!(notes_outside(&report), "{name}: {:?}", report.notes);
        let path = place.file("a.obj", format!("mtllib a.mtl\n{triangle}"));
        for name in [name.clone(), name.replace('/', "\\")] {
            place.file("a.mtl", format!("newmtl m\nmap_Kd {name}\n"));
            let (scene, report) = read_scene(&path, &SceneReadOptions::default()).unwrap();
            assert!(notes_outside(&report) && scene.textures().is_empty(), "{name}: {:?}", report.notes);
        }
    }
}

#[test]
fn names_that_stay_in_the_folder_are_found_through_folders_and_links() {
    let place = Place::new();
    let file = Gltf::square();
    place.file("data/deep/a.bin", &file.buffer);
    #[cfg(unix)]
    std::os::unix::fs::symlink("data/deep", place.root.path().join("scene/link")).unwrap();
    #[cfg(not(unix))]
    place.file("link/a.bin", &file.buffer);
    for uri in ["data/deep/a.bin", "./data/../data/deep/a.bin", "link/a.bin"] {
        let path = place.file("a.gltf", Gltf::square().with("/buffers/0/uri", json!(uri)).json.to_string());
        assert!(read_scene(&path, &SceneReadOptions::default()).is_ok(), "{uri}");
    }
    let missing = place.file("a.gltf", Gltf::square().with("/buffers/0/uri", json!("data/none")).json.to_string());
    let error = read_scene(missing, &SceneReadOptions::default()).unwrap_err();
    assert!(matches!(error, SceneError::Io { .. }), "a missing file is no attack: {error}");
}

#[test]
fn document_and_scene_are_of_one_reading() {
    let place = Place::new();
    place.file("a.bin", &Gltf::square().buffer);
    let path = place.file("a.gltf", Gltf::square().with("/buffers/0/uri", json!("a.bin")).json.to_string());
    let (scene, _, document) =
        GltfReader::open(&path, &SceneReadOptions::default()).and_then(GltfReader::into_scene_and_document).unwrap();
    assert_eq!(scene.meshes(), read_scene(&path, &SceneReadOptions::default()).unwrap().0.meshes(), "the same scene");
    assert_eq!(document.bytes, Gltf::square().buffer, "the buffer");
    assert_eq!(document.json["buffers"][0], json!({"byteLength": 60}), "embedded: {}", document.json["buffers"]);
    assert_eq!(document.json["bufferViews"][1]["byteOffset"], Value::from(48), "views");
}
