//! Files that are dropped on the window: good, corrupt and too large ones.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use eframe::egui::DroppedFile;
use egui_kittest::Harness;
use lobe::sh::{Quantity, Rgb, ShFile, ShVec, write_sh_json};
use lobe_viewer::{Kept, RoomName, UserFolder, ViewerApp};

use crate::wait::step_until;

/// A file as the system hands it to the window.
#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

fn drop_file(harness: &mut Harness<'_, ViewerApp>, path: &Path) {
    harness.input_mut().dropped_files.push(Arc::new(Dropped(path.into())));
    harness.run_steps(2);
    step_until(harness, |app| app.scene().is_idle());
}

#[test]
fn files_that_are_dropped_are_opened_or_told_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let user = UserFolder::at(folder.path().join("user"));
    let mut kept = Kept::default();
    (kept.scene.scene, kept.scene.order, kept.room) = ("built-in:furnace".into(), 1, RoomName::Functions);
    kept.write(&user);
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("one.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    std::fs::write(at("torn.glb"), b"glTF\x02\0\0\0\xff\xff\xff\x7f").unwrap();
    std::fs::write(at("torn.exr"), [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0, 0xff, 0xff]).unwrap();
    // A cube of which each face has its number for a color.
    std::fs::create_dir(at("cube")).unwrap();
    for (k, face) in ["px", "nx", "py", "ny", "pz", "nz"].into_iter().enumerate() {
        let color = [1.0 + k as f32; 3].map(f32::to_le_bytes).concat();
        std::fs::write(at("cube").join(format!("{face}.pfm")), [b"PF\n1 1\n-1.0\n", &*color].concat()).unwrap();
    }
    // A hole of 300 MB, which takes no room.
    File::create(at("huge.hdr")).unwrap().set_len(300_000_000).unwrap();
    File::create(at("huge.glb")).unwrap().set_len(300_000_000).unwrap();
    let app = ViewerApp::new(None, user, &[]);
    let mut harness =
        Harness::builder().with_size([1000.0, 700.0]).build_ui_state(|ui, app: &mut ViewerApp| app.show(ui), app);
    drop_file(&mut harness, &at("one.obj"));
    assert_eq!(harness.state().room(), RoomName::Scene, "what is dropped is shown");
    assert_eq!(harness.state().scene().edits().scene, at("one.obj"), "the scene");
    assert_eq!(harness.state().scene().message(), None, "and nothing is wrong");
    drop_file(&mut harness, &at("cube"));
    assert_eq!(harness.state().scene().edits().sky, at("cube"), "a folder of six faces is a sky");
    assert_eq!(harness.state().scene().message(), None, "and nothing is wrong");
    let light = ShVec::constant(2, Rgb::new(2.0, 1.0, 0.5));
    write_sh_json(at("light.sh.json"), &ShFile::new(Quantity::Radiance, light)).unwrap();
    drop_file(&mut harness, &at("light.sh.json"));
    assert_eq!(harness.state().scene().edits().sky, at("light.sh.json"), "an expansion is a sky");
    assert_eq!(harness.state().room(), RoomName::Scene, "and no scene that moves");
    for name in ["torn.glb", "torn.exr", "huge.hdr", "huge.glb", "none.obj"] {
        drop_file(&mut harness, &at(name));
        let message = harness.state().scene().message().unwrap_or_default().to_owned();
        assert!(message.contains(name) && message.lines().count() == 1, "{name}: {message:?}");
        assert_eq!(harness.state().scene().edits().scene, at("one.obj"), "{name}: the scene is still there");
        assert!(harness.state().scene().sky().is_some(), "{name}: and the sky");
    }
}
