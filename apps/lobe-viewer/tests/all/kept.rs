//! What the window remembers, and the window as a whole.

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lobe_viewer::{Kept, RoomName, SceneLamp, Theme, UserFolder, ViewerApp};

#[test]
fn what_is_written_is_read_again_and_nonsense_is_as_a_first_start() {
    let folder = tempfile::tempdir().unwrap();
    let user = UserFolder::at(folder.path());
    let mut kept = Kept::default();
    (kept.room, kept.theme, kept.zoom) = (RoomName::Functions, Theme::Light, 1.5);
    kept.scene.lamps.push(SceneLamp::default());
    for number in 0..20 {
        kept.remember(format!("{number}.glb").as_ref());
    }
    assert_eq!((kept.recent.len(), kept.recent[0].to_str()), (8, Some("19.glb")), "the last files, the latest first");
    kept.write(&user);
    assert_eq!(Kept::read(&user), kept, "read again");
    for nonsense in ["", "{", "[1, 2]", r#"{"zoom": "large"}"#] {
        std::fs::write(folder.path().join("window.json"), nonsense).unwrap();
        assert_eq!(Kept::read(&user), Kept::default(), "{nonsense:?}");
    }
    std::fs::write(folder.path().join("window.json"), r#"{"zoom": 1e9, "scene": {"order": 99}, "later": 1}"#).unwrap();
    let read = Kept::read(&user);
    assert_eq!((read.zoom, read.scene.order), (3.0, 8), "numbers out of range");
    assert_eq!(Kept::read(&UserFolder::none()), Kept::default(), "without a folder");
}

#[test]
fn rooms_open_by_name_and_nothing_panics_in_a_window_of_any_size() {
    let folder = tempfile::tempdir().unwrap();
    let user = UserFolder::at(folder.path());
    let mut kept = Kept::default();
    (kept.scene.scene, kept.scene.order) = ("built-in:furnace".into(), 1);
    kept.write(&user);
    let app = ViewerApp::new(None, user, &[]);
    let mut harness =
        Harness::builder().with_size([1280.0, 800.0]).build_ui_state(|ui, app: &mut ViewerApp| app.show(ui), app);
    harness.run_steps(3);
    for room in [RoomName::Functions, RoomName::Sky, RoomName::Motion, RoomName::Scene] {
        harness.get_all_by_label(room.title()).next().unwrap().click();
        harness.run_steps(2);
        assert_eq!(harness.state().room(), room, "the room that was pressed");
        for size in [[1.0, 1.0], [40.0, 30.0], [700.0, 90.0], [1280.0, 800.0]] {
            harness.set_size(size.into());
            harness.run_steps(2);
        }
    }
}
