//! The state that is kept, and the window as a whole.

use eframe::egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lobe_viewer::{Kept, MotionView, Orbit, RoomName, SceneLamp, Shape, Taming, Theme, UserFolder, ViewerApp};

#[test]
fn what_is_written_is_read_again_and_nonsense_is_as_a_first_start() {
    let folder = tempfile::tempdir().unwrap();
    let user = UserFolder::at(folder.path());
    let mut kept = Kept::default();
    (kept.room, kept.theme, kept.zoom) = (RoomName::Functions, Theme::Light, 1.5);
    kept.rooms.scene.lamps.push(SceneLamp::default());
    (kept.rooms.motion.source, kept.rooms.motion.view) = ("built-in:walking-figure".into(), MotionView::Beside);
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
    assert_eq!((read.zoom, read.rooms.scene.order), (2.0, 8), "numbers out of range");
    let text = r#"{"zoom": 1.5, "theme": "mauve", "motion": {"order": "many"}, "scene": {"order": 3}}"#;
    std::fs::write(folder.path().join("window.json"), text).unwrap();
    let read = Kept::read(&user);
    assert_eq!((read.zoom, read.rooms.scene.order), (1.5, 3), "what can be read beside what cannot");
    assert_eq!((read.theme, read.rooms.motion), (Theme::System, Kept::default().rooms.motion), "what cannot");
    assert_eq!(Kept::read(&UserFolder::none()), Kept::default(), "without a folder");
}

#[test]
fn what_tames_the_light_is_read_from_the_files_of_older_versions() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"{"scene": {"taming": {"lanczos": 9.5}, "order": 6}, "sky": {"taming": "dering"},
        "functions": {"taming": {"gauss": 0.2}}, "motion": {"taming": {"hanning": 5.0}}, "zoom": 1.25}"#;
    std::fs::write(folder.path().join("window.json"), text).unwrap();
    let read = Kept::read(&UserFolder::at(folder.path()));
    assert_eq!((read.zoom, read.rooms.scene.order), (1.25, 6), "the file was read");
    assert_eq!(read.rooms.scene.taming, Taming::Lanczos { width: 9.5, power: 1.0 }, "a window whose power was 1");
    let others = [read.rooms.sky.taming, read.rooms.functions.taming, read.rooms.motion.taming];
    assert_eq!(others, [Taming::Dering, Taming::Gauss(0.2), Taming::Hanning(5.0)], "and the others");
}

/// The same JSON with every number, in turn those of whole numbers or of all others, replaced.
fn with_numbers(value: &mut serde_json::Value, whole: bool, number: &serde_json::Value) {
    match value {
        serde_json::Value::Number(found) if whole == (found.is_u64() || found.is_i64()) => *value = number.clone(),
        serde_json::Value::Array(all) => all.iter_mut().for_each(|value| with_numbers(value, whole, number)),
        serde_json::Value::Object(all) => all.values_mut().for_each(|value| with_numbers(value, whole, number)),
        _ => {}
    }
}

/// The largest number in JSON.
fn largest(value: &serde_json::Value) -> f64 {
    match value {
        serde_json::Value::Number(found) => found.as_f64().unwrap().abs(),
        serde_json::Value::Array(all) => all.iter().map(largest).fold(0.0, f64::max),
        serde_json::Value::Object(all) => all.values().map(largest).fold(0.0, f64::max),
        // Numbers that are none are written as null.
        serde_json::Value::Null => f64::INFINITY,
        _ => 0.0,
    }
}

#[test]
#[ignore = "long: of the nightly group"]
fn every_number_that_is_kept_comes_back_in_its_range_and_the_rooms_stand_it() {
    let folder = tempfile::tempdir().unwrap();
    let user = UserFolder::at(folder.path());
    let mut kept = Kept::default();
    kept.rooms.scene.scene = "built-in:furnace".into();
    kept.rooms.scene.lamps = vec![SceneLamp::default(); 3];
    (kept.rooms.scene.taming, kept.rooms.sky.taming, kept.rooms.functions.taming) =
        (Taming::Hanning(3.0), Taming::Gauss(0.2), Taming::Lanczos { width: 3.0, power: 2.5 });
    kept.rooms.motion.taming = Taming::Laplacian(0.25);
    let orbits = [
        &mut kept.rooms.orbit,
        &mut kept.rooms.sky_orbit,
        &mut kept.rooms.functions_orbit,
        &mut kept.rooms.motion_orbit,
    ];
    orbits.into_iter().for_each(|orbit| *orbit = Some(Orbit::default()));
    kept.size = Some([1000.0, 700.5]);
    kept.rooms.functions.shape = Shape::Cone(20.5);
    kept.rooms.sky.replace(3, lobe::sh::Rgb::new(0.5, 0.25, 0.125));
    let good = serde_json::to_value(&kept).unwrap();
    let bad = |whole: bool, number: serde_json::Value| {
        let mut value = good.clone();
        with_numbers(&mut value, whole, &number);
        value
    };
    let others = [1e30, -1e30, 0.0].map(|number| bad(false, number.into()));
    let wholes = [0_u32, u32::MAX].map(|number| bad(true, number.into()));
    for value in others.into_iter().chain(wholes) {
        std::fs::write(folder.path().join("window.json"), value.to_string()).unwrap();
        let read = Kept::read(&user);
        assert_eq!(read.rooms.scene.scene.to_str(), Some("built-in:furnace"), "it was read: {value}");
        let back = serde_json::to_value(&read).unwrap();
        assert!(largest(&back) <= 1e6, "{back}");
        assert!((1..=8).contains(&read.rooms.scene.order) && (1..=8).contains(&read.rooms.functions.order), "{back}");
        let samples = read.rooms.scene.samples;
        assert!((16..=4096).contains(&samples) && samples.is_power_of_two(), "{back}");
        assert!((1..=8).contains(&read.rooms.motion.order) && (1..=8).contains(&read.rooms.sky.order), "{back}");
        assert!(read.export.frames >= 2 && read.export.size.iter().all(|side| (1..=4096).contains(side)), "{back}");
        assert!(read.rooms.orbit.unwrap().distance > 0.0 && read.rooms.orbit.unwrap().camera().is_some(), "{back}");
        let app = ViewerApp::new(None, user.clone(), &[]);
        let mut harness =
            Harness::builder().with_size([480.0, 360.0]).build_ui_state(|ui, app: &mut ViewerApp| app.show(ui), app);
        for room in RoomName::ALL {
            harness.get_all_by_label(room.title()).next().unwrap().click();
            harness.run_steps(3);
            assert_eq!(harness.state().room(), room, "the room that was chosen");
        }
    }
}

#[test]
fn rooms_open_by_name_and_nothing_panics_in_a_window_of_any_size() {
    let folder = tempfile::tempdir().unwrap();
    let user = UserFolder::at(folder.path());
    let mut kept = Kept::default();
    (kept.rooms.scene.scene, kept.rooms.scene.order, kept.rooms.scene.samples) = ("built-in:furnace".into(), 1, 16);
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

#[test]
fn the_list_of_keys_fits_into_a_small_window_and_scrolls() {
    let folder = tempfile::tempdir().unwrap();
    let user = UserFolder::at(folder.path());
    let mut kept = Kept::default();
    // As a window of 1280 x 720 at 150 %.
    (kept.rooms.scene.scene, kept.rooms.scene.order, kept.room) = ("built-in:furnace".into(), 1, RoomName::Functions);
    kept.rooms.scene.samples = 16;
    kept.write(&user);
    let size = [853.0, 480.0];
    let app = ViewerApp::new(None, user, &[]);
    let mut harness = Harness::builder().with_size(size).build_ui_state(|ui, app: &mut ViewerApp| app.show(ui), app);
    harness.run_steps(2);
    harness.key_press(Key::F1);
    harness.run_steps(3);
    let window = |harness: &Harness<'_, ViewerApp>| harness.get_by_label("Keys and mouse").rect();
    assert!(window(&harness).bottom() <= size[1] && window(&harness).top() >= 0.0, "{:?}", window(&harness));
    let last = |harness: &Harness<'_, ViewerApp>| harness.get_by_label("this list").rect().bottom();
    assert!(last(&harness) > size[1], "the last line is below at first: {}", last(&harness));
    harness.get_by_label("this list").scroll_to_me();
    harness.run_steps(30);
    assert!(last(&harness) <= size[1], "and comes up: {}", last(&harness));
}
