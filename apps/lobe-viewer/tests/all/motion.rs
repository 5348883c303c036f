//! The room of motion, without a device: files that are opened, and spheres that are fitted.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use eframe::egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use lobe::io::Job;
use lobe::motion::{MovingMethod, MovingOptions, MovingShading};
use lobe::sh::{Dir, Expansion as _, Rotation};
use lobe::shadow::{SphereFitMethod, SphereFitOptions, fit_spheres, write_spheres};
use lobe_viewer::{
    MotionEdits, MotionRoom, MotionView, OpenedSky, ReadLimits, Step, Taming, moving_bake_options, open_moving,
    open_sky,
};

use crate::wait::step_until;

/// Corners and triangles of a tetrahedron that encloses a volume.
const CORNERS: [[f32; 3]; 4] = [[0.5, 0.0, -0.3], [-0.3, 0.4, -0.3], [-0.3, -0.4, -0.3], [0.0, 0.0, 0.5]];
const TRIANGLES: [[u16; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

/// A tetrahedron that slides by 2 m in a second, as glTF with its numbers beside it.
fn sliding(folder: &Path) -> PathBuf {
    let numbers = |all: &[f32]| all.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let mut bytes = numbers(CORNERS.as_flattened());
    bytes.extend(TRIANGLES.as_flattened().iter().flat_map(|i| i.to_le_bytes()));
    bytes.extend(numbers(&[0.0, 1.0]));
    bytes.extend(numbers(&[0.0, 0.0, 0.0, 2.0, 0.0, 0.0]));
    std::fs::write(folder.join("sliding.bin"), &bytes).unwrap();
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
        "nodes": [{{"name": "wedge", "mesh": 0}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
        "animations": [{{"name": "Slide", "channels": [{{"sampler": 0, "target": {{"node": 0, "path": "translation"}}}}],
            "samplers": [{{"input": 2, "output": 3}}]}}],
        "buffers": [{{"uri": "sliding.bin", "byteLength": {}}}],
        "bufferViews": [{{"buffer": 0, "byteOffset": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 24}},
            {{"buffer": 0, "byteOffset": 72, "byteLength": 8}}, {{"buffer": 0, "byteOffset": 80, "byteLength": 24}}],
        "accessors": [
            {{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-0.3, -0.4, -0.3], "max": [0.5, 0.4, 0.5]}},
            {{"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}},
            {{"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]}},
            {{"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"}}]}}"#,
        bytes.len()
    );
    let path = folder.join("sliding.gltf");
    std::fs::write(&path, text).unwrap();
    path
}

/// A ground and a tetrahedron that falls on it, as a description.
pub(crate) fn described(folder: &Path) -> PathBuf {
    let mut wedge = String::new();
    for [x, y, z] in CORNERS {
        writeln!(wedge, "v {x} {y} {z}").unwrap();
    }
    for [a, b, c] in TRIANGLES {
        writeln!(wedge, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    std::fs::write(folder.join("wedge.obj"), wedge).unwrap();
    std::fs::write(folder.join("ground.obj"), "v -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2\nf 1 2 3\nf 1 3 4\n").unwrap();
    let text = r#"{"format": "lobe-scene", "version": 1, "still": ["ground.obj"],
        "entities": [{"name": "falling", "mesh": "wedge.obj",
            "keys": [{"time": 0, "translation": [0, 0, 2]}, {"time": 2, "translation": [0, 0, 1]}]}]}"#;
    let path = folder.join("falls.json");
    std::fs::write(&path, text).unwrap();
    path
}

pub(crate) struct Shown {
    pub(crate) room: MotionRoom,
    sky: OpenedSky,
}

pub(crate) fn open(source: &Path) -> Harness<'static, Shown> {
    let mut room = MotionRoom::new(MotionEdits::default());
    room.open(source);
    let show = |ui: &mut eframe::egui::Ui, shown: &mut Shown| shown.room.ui(ui, None, Some(&shown.sky));
    let state = Shown { room, sky: open_sky("made:even".as_ref(), &ReadLimits::default()).unwrap() };
    Harness::builder().with_size([1000.0, 1400.0]).build_ui_state(show, state)
}

/// Steps until `is_so`.
pub(crate) fn wait(harness: &mut Harness<'_, Shown>, is_so: impl Fn(&MotionRoom) -> bool) {
    step_until(harness, |shown| is_so(&shown.room));
}

#[test]
fn files_that_move_are_opened_baked_and_lit() {
    let folder = tempfile::tempdir().unwrap();
    for (path, part, span) in
        [(sliding(folder.path()), "wedge", [0.0, 1.0]), (described(folder.path()), "falling", [0.0, 2.0])]
    {
        let scene = open_moving(&path, &ReadLimits::default()).unwrap();
        assert_eq!(scene.span(), span, "{}", path.display());
        let mut harness = open(&path);
        wait(&mut harness, MotionRoom::is_ready);
        let room = &harness.state().room;
        assert!(room.parts().iter().any(|name| name.contains(part)), "{:?}", room.parts());
        assert_eq!((room.message(), room.source()), (None, path.as_path()), "nothing went wrong");
    }
}

#[test]
fn as_many_spheres_are_fitted_as_the_slider_says() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = open(&described(folder.path()));
    wait(&mut harness, MotionRoom::is_ready);
    harness.get_by_label("Spheres, SH exponentials").click();
    wait(&mut harness, |room| room.spheres() == 16);
    assert_eq!(harness.state().room.edits().view, MotionView::Exponentials, "the view that was pressed");
    harness.get_all_by_label("Spheres of a part").next().unwrap().focus();
    harness.run_steps(2);
    for count in [15, 14] {
        harness.key_press(Key::ArrowLeft);
        wait(&mut harness, |room| room.spheres() == count);
    }
    assert_eq!(harness.state().room.message(), None, "and nothing went wrong");
}

#[test]
fn files_that_cannot_move_are_told_in_one_line_and_leave_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let good = described(folder.path());
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("torn.glb"), b"glTF\x02\0\0\0\xff\xff\xff\x7f").unwrap();
    std::fs::write(at("torn.json"), r#"{"format": "lobe-scene", "version": 1, "entities": [{"mesh": "none.glb"}]}"#)
        .unwrap();
    std::fs::write(at("notes.txt"), "no scene").unwrap();
    let mut harness = open(&good);
    wait(&mut harness, MotionRoom::is_ready);
    for name in ["torn.glb", "torn.json", "notes.txt", "gone.glb"] {
        harness.state_mut().room.open(&at(name));
        wait(&mut harness, |room| room.message().is_some());
        let message = harness.state().room.message().unwrap().to_owned();
        assert!(message.lines().count() == 1 && message.len() > 20, "{name}: {message}");
        assert_eq!(harness.state().room.source(), good, "{name}: the scene before is opened again");
        wait(&mut harness, MotionRoom::is_ready);
        assert_eq!(harness.state().room.message(), Some(message.as_str()), "{name}: and the message remains");
    }
}

#[test]
fn a_file_that_is_opened_again_is_read_again_and_its_objects_can_be_moved() {
    let folder = tempfile::tempdir().unwrap();
    let source = described(folder.path());
    let mut harness = open(&source);
    wait(&mut harness, MotionRoom::is_ready);
    let text = std::fs::read_to_string(&source).unwrap();
    std::fs::write(&source, text.replace("falling", "fallen")).unwrap();
    harness.state_mut().room.open(&source);
    wait(&mut harness, |room| room.is_ready() && room.parts().iter().any(|name| name.contains("fallen")));
    harness.get_by_label("Move objects by hand").click();
    harness.run_steps(4);
    let room = &harness.state().room;
    assert!(room.edits().is_by_hand && room.message().is_none(), "{:?}", room.message());
    assert!(harness.query_by_label("Put back").is_some(), "and there are hands");
}

#[test]
fn a_file_that_is_torn_when_it_is_opened_again_is_told_and_leaves_its_scene_until_it_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let source = described(folder.path());
    let mut harness = open(&source);
    harness.state_mut().room.pause_at(0.5);
    wait(&mut harness, MotionRoom::is_ready);
    let before = harness.state().room.parts().to_vec();
    let text = std::fs::read_to_string(&source).unwrap();
    // Torn, of a mesh that is not there, and gone.
    let without_mesh = r#"{"format": "lobe-scene", "version": 1, "entities": [{"mesh": "none.glb"}]}"#;
    for torn in [Some(&text[..text.len() / 2]), Some(without_mesh), None] {
        match torn {
            Some(torn) => std::fs::write(&source, torn).unwrap(),
            None => std::fs::remove_file(&source).unwrap(),
        }
        harness.state_mut().room.open(&source);
        wait(&mut harness, |room| room.message().is_some());
        harness.run_steps(4);
        let room = &harness.state().room;
        assert_eq!(room.message().unwrap().lines().count(), 1, "{:?}", room.message());
        assert_eq!((room.parts(), room.source()), (&*before, source.as_path()), "the scene that was there");
        assert!(room.is_ready() && !room.is_at_work(), "is shown, and not opened again");
        assert!(harness.query_by_label_contains("products of shadow fields").is_some(), "as the line below it says");
        assert!(harness.query_by_label("Preparing").is_none(), "nothing is waited for");
    }
    // It obeys its controls.
    harness.state_mut().room.edits_mut().order = 2;
    wait(&mut harness, |room| room.light().is_some_and(|light| light.order() == 2));
    std::fs::write(&source, text.replace("falling", "fallen")).unwrap();
    harness.state_mut().room.open(&source);
    wait(&mut harness, |room| room.is_ready() && room.parts().iter().any(|name| name.contains("fallen")));
    assert_eq!(harness.state().room.message(), None, "the whole file is shown, and nothing is told");
}

#[test]
fn a_scene_stays_where_another_one_fails_or_is_stopped_although_its_file_is_gone() {
    let folder = tempfile::tempdir().unwrap();
    let source = described(folder.path());
    let mut harness = open(&source);
    wait(&mut harness, MotionRoom::is_ready);
    std::fs::remove_file(&source).unwrap();
    let torn = folder.path().join("torn.glb");
    std::fs::write(&torn, b"glTF").unwrap();
    harness.state_mut().room.open(&torn);
    wait(&mut harness, |room| room.message().is_some());
    let is_there = |room: &MotionRoom| room.is_ready() && room.source() == source && !room.is_at_work();
    assert!(is_there(&harness.state().room), "after a failure: {:?}", harness.state().room.message());
    harness.state_mut().room.open("built-in:three-objects".as_ref());
    wait(&mut harness, MotionRoom::is_at_work);
    harness.key_press(Key::Escape);
    wait(&mut harness, |room| room.message().is_some());
    let message = harness.state().room.message().unwrap().to_owned();
    assert!(is_there(&harness.state().room) && message.contains("the one before"), "after a stop: {message}");
    assert!(harness.query_by_label("Bake").is_none(), "there is nothing to begin again");
}

#[test]
fn a_change_of_the_scene_that_is_taken_back_while_it_is_opened_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let source = described(folder.path());
    let mut harness = open(&source);
    wait(&mut harness, MotionRoom::is_ready);
    std::fs::remove_file(&source).unwrap();
    harness.state_mut().room.open("built-in:three-objects".as_ref());
    wait(&mut harness, MotionRoom::is_at_work);
    harness.state_mut().room.step(Step::Undo);
    harness.run_steps(2);
    let room = &harness.state().room;
    assert_eq!((room.source(), room.message()), (source.as_path(), None), "what was there, and not read again");
    assert!(room.is_ready() && room.parts().iter().any(|name| name == "falling"), "{:?}", room.parts());
}

#[test]
fn a_scene_that_comes_back_has_its_parts_where_they_were_put_also_while_they_are_animated() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = open(&described(folder.path()));
    wait(&mut harness, MotionRoom::is_ready);
    let kept = |room: &MotionRoom| serde_json::to_value(room.edits()).unwrap();
    let mut put = kept(&harness.state().room);
    for hand in put["hands"].as_array_mut().unwrap() {
        hand["turn"] = 0.5_f64.into();
    }
    *harness.state_mut().room.edits_mut() = serde_json::from_value(put.clone()).unwrap();
    harness.run_steps(2);
    let torn = folder.path().join("torn.glb");
    std::fs::write(&torn, b"glTF").unwrap();
    harness.state_mut().room.open(&torn);
    wait(&mut harness, |room| room.message().is_some());
    let found = kept(&harness.state().room);
    assert_eq!((&found["hands"], &found["is_by_hand"]), (&put["hands"], &put["is_by_hand"]), "as they were put");
}

#[test]
fn a_scene_that_is_stopped_before_any_other_was_there_waits_for_a_button() {
    let folder = tempfile::tempdir().unwrap();
    let mut edits = MotionEdits::default();
    edits.source = "built-in:walking-figure".into();
    let show = |ui: &mut eframe::egui::Ui, shown: &mut Shown| shown.room.ui(ui, None, Some(&shown.sky));
    let sky = open_sky("made:even".as_ref(), &ReadLimits::default()).unwrap();
    let state = Shown { room: MotionRoom::new(edits), sky };
    let mut harness = Harness::builder().with_size([1000.0, 1400.0]).build_ui_state(show, state);
    wait(&mut harness, MotionRoom::is_at_work);
    harness.key_press(Key::Escape);
    wait(&mut harness, |room| room.message().is_some());
    harness.run_steps(4);
    let room = &harness.state().room;
    assert_eq!(room.source().to_str(), Some("built-in:walking-figure"), "no other scene is opened in its place");
    assert!(!room.is_at_work() && !room.is_ready(), "and nothing goes on");
    assert!(harness.query_by_label("Nothing is baked").is_some(), "which the line below the picture says");
    // Another scene can be opened.
    let path = described(folder.path());
    harness.state_mut().room.open(&path);
    wait(&mut harness, MotionRoom::is_ready);
    assert_eq!(harness.state().room.message(), None, "and is shown");
}

#[test]
fn a_file_of_spheres_that_is_opened_again_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wedge.safetensors");
    let source = described(folder.path());
    let scene = open_moving(&source, &ReadLimits::default()).unwrap();
    let wedge = scene.parts().iter().find(|part| part.name == "falling").unwrap();
    let mut harness = open(&source);
    harness.state_mut().room.edits_mut().view = MotionView::Exponentials;
    for count in [3, 2] {
        let options = SphereFitOptions::default().count(count).samples(200);
        write_spheres(&path, &fit_spheres(&wedge.scene, &options, Job::default()).unwrap().0).unwrap();
        harness.state_mut().room.open_part_file(&path);
        wait(&mut harness, |room| room.spheres() == count || room.message().is_some());
        let room = &harness.state().room;
        assert_eq!((room.message(), room.spheres()), (None, count), "those of the file as it is now");
    }
}

#[test]
fn the_order_on_the_screen_is_that_of_the_light_and_of_all_that_is_baked() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = open(&sliding(folder.path()));
    wait(&mut harness, MotionRoom::is_ready);
    harness.get_all_by_label("Order").next().unwrap().focus();
    harness.run_steps(2);
    for order in [3, 2] {
        harness.key_press(Key::ArrowLeft);
        wait(&mut harness, |room| room.light().is_some_and(|light| light.order() == order));
        let room = &harness.state().room;
        assert_eq!((room.edits().order, room.message()), (order, None), "and nothing went wrong");
        let text = format!("order {order}, products of shadow fields");
        assert!(harness.query_by_label_contains(&text).is_some(), "{text}");
    }
}

#[test]
fn the_light_is_that_of_the_library_turned_and_tamed_by_keys() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = open(&described(folder.path()));
    harness.state_mut().sky = open_sky("bundled:sunset".as_ref(), &ReadLimits::default()).unwrap();
    wait(&mut harness, MotionRoom::is_ready);
    harness.get_by_label("Play").click();
    harness.run_steps(2);
    // Play has no keyboard: the keys are those of the picture.
    harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowRight);
    harness.run_steps(1);
    harness.key_press(Key::D);
    harness.key_press(Key::CloseBracket);
    harness.run_steps(2);
    let edits = harness.state().room.edits().clone();
    assert_eq!((edits.taming, edits.exposure), (Taming::Dering, 0.5), "by keys");
    // A drag of the whole height is half a turn, and a key a 36th of that.
    assert!((edits.turn.to_degrees() - 5.0).abs() < 1e-9, "{}", edits.turn);
    let sky = open_sky("bundled:sunset".as_ref(), &ReadLimits::default()).unwrap();
    let expected = Taming::Dering.tamed(&sky.light.resized(4)).rotated(&Rotation::from_axis_angle(Dir::Z, edits.turn));
    wait(&mut harness, |room| room.light() == Some(&expected));
    let turn = harness.get_all_by_label("Turn of the sky").next().unwrap().accesskit_node().numeric_value().unwrap();
    assert!((turn - 5.0).abs() < 1e-9, "the slider says {turn}");
}

#[test]
fn both_ways_of_one_moment_are_those_of_the_library() {
    let folder = tempfile::tempdir().unwrap();
    let source = described(folder.path());
    let mut harness = open(&source);
    harness.state_mut().room.pause_at(0.0);
    harness.get_by_label("All three beside each other").click();
    let both = [MovingMethod::Fields, MovingMethod::Exponentials];
    wait(&mut harness, |room| both.iter().all(|method| room.radiance(*method).is_some()));
    let room = &harness.state().room;
    let light = room.light().unwrap().clone();
    let found: Vec<_> = both.iter().map(|method| room.radiance(*method).unwrap().to_vec()).collect();
    for (found, method) in found.iter().zip(both) {
        let mut scene = open_moving(&source, &ReadLimits::default()).unwrap();
        let options = moving_bake_options(4, SphereFitMethod::Variational, 16, true);
        scene.bake(method, &options, Job::default()).unwrap();
        let shading = MovingShading::new(MovingOptions::default().order(4).method(method)).unwrap();
        let expected = shading.exit_radiance(&scene.at(0.0).unwrap(), &light).unwrap();
        assert_eq!(*found, expected, "{method:?}");
    }
    assert_ne!(found[0], found[1], "two ways");
}

#[test]
fn the_camera_is_moved_by_keys_as_by_the_mouse() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = open(&described(folder.path()));
    harness.state_mut().room.pause_at(0.0);
    wait(&mut harness, MotionRoom::is_ready);
    let before = *harness.state().room.orbit();
    let mut expected = before;
    harness.key_press(Key::ArrowRight);
    harness.run_steps(1);
    expected.turn(1.0 / 36.0, 0.0);
    assert_eq!(*harness.state().room.orbit(), expected, "turned");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::ArrowDown);
    harness.run_steps(1);
    expected.pan(0.0, 1.0 / 36.0);
    assert_eq!(*harness.state().room.orbit(), expected, "moved");
    harness.key_press(Key::Plus);
    harness.run_steps(1);
    expected.zoom(1.1);
    assert_eq!(*harness.state().room.orbit(), expected, "nearer");
    harness.key_press(Key::F);
    harness.run_steps(1);
    let framed = harness.state().room.orbit();
    assert_eq!((framed.distance, framed.target), (before.distance, before.target), "framed as at first");
}

#[test]
fn bakes_stop_at_a_key_and_begin_again_at_a_button() {
    let mut harness = open("built-in:three-objects".as_ref());
    wait(&mut harness, MotionRoom::is_at_work);
    harness.key_press(Key::Escape);
    wait(&mut harness, |room| room.message().is_some());
    let room = &harness.state().room;
    assert!(room.message().unwrap().contains("Bake"), "{:?}", room.message());
    assert!(!room.is_ready() && !room.is_at_work(), "nothing goes on, and nothing is shown");
    harness.get_by_label("Bake").click();
    wait(&mut harness, MotionRoom::is_at_work);
    assert_eq!(harness.state().room.message(), None, "and it begins again");
    // The button does the same; the frame in which work begins may be drawn without it.
    harness.run_steps(1);
    harness.get_by_label("Cancel").click();
    wait(&mut harness, |room| room.message().is_some());
}

#[test]
fn moments_say_where_they_were_lit() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = open(&described(folder.path()));
    wait(&mut harness, MotionRoom::is_ready);
    harness.get_by_label("the processor").click();
    harness.run_steps(2);
    // Without a device it is the processor anyway.
    assert!(harness.query_by_label_contains("ms on the processor").is_some(), "the line below the picture");
}
