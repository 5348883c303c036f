//! The room of scenes, without a device: what it opens, bakes, remembers and undoes.

use std::time::Duration;

use eframe::egui::{Context, Key};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lobe::env::{EnvMap, write_env};
use lobe::prt::BakeMode;
use lobe::render::Surfaces;
use lobe::sh::{Dir, Expansion as _, Rgb, Zonal};
use lobe_viewer::{Mode, Orbit, SceneEdits, SceneLamp, SceneRoom, Step, UserFolder, transfer_of};

use crate::wait::step_until;

/// The least scene of the program.
fn least() -> SceneEdits {
    let mut edits = SceneEdits::default();
    edits.scene = "built-in:furnace".into();
    edits.sky = "made:even".into();
    edits.order = 2;
    edits
}

fn open(change: impl FnOnce(&mut SceneEdits)) -> Harness<'static, SceneRoom> {
    let mut edits = least();
    change(&mut edits);
    let room = SceneRoom::new(edits, None, UserFolder::none());
    let show = |ui: &mut eframe::egui::Ui, room: &mut SceneRoom| {
        room.advance(ui.ctx());
        room.ui(ui, None);
    };
    Harness::builder().with_size([1100.0, 1400.0]).build_ui_state(show, room)
}

/// Steps until nothing is being opened or baked.
fn settle(harness: &mut Harness<'_, SceneRoom>) {
    harness.run_steps(2);
    step_until(harness, SceneRoom::is_idle);
}

#[test]
fn it_opens_bakes_and_shows_each_mode_by_its_key_and_by_its_name() {
    let mut harness = open(|_| ());
    settle(&mut harness);
    let transfer = harness.state().transfer().unwrap().clone();
    assert_eq!((transfer.order(), harness.state().message()), (2, None), "baked");
    assert!(harness.query_by_label("Baked: order 2, 256 paths").is_some(), "and said so");
    harness.get_by_label("Shadowed").click();
    harness.run_steps(2);
    assert_eq!(harness.state().edits().mode, Mode::Shadowed, "by name");
    let shadowed = harness.state().transfer().unwrap().clone();
    harness.key_press(Key::Num4);
    harness.run_steps(2);
    assert_eq!(harness.state().edits().mode, Mode::Difference, "by key");
    let difference = harness.state().transfer().unwrap().clone();
    for (k, found) in difference.coefficients().iter().enumerate().take(64) {
        let expected = transfer.coefficients()[k] - shadowed.coefficients()[k];
        assert!((found - expected).abs() < 1e-6, "coefficient {k}: {found}, expected {expected}");
    }
    harness.key_press(Key::Num1);
    harness.run_steps(2);
    assert!(harness.state().transfer().is_none(), "light by normals needs none");
}

#[test]
fn two_frames_of_a_scene_are_drawn_before_its_bake_takes_the_processors() {
    let ctx = Context::default();
    let mut room = SceneRoom::new(least(), None, UserFolder::none());
    let mut frame = |pause: u64| {
        std::thread::sleep(Duration::from_millis(pause));
        room.advance(&ctx);
        room.export().map(|_| room.transfer().is_some())
    };
    while frame(1).is_none() {}
    for k in 1..=2 {
        // Longer than this scene takes to be baked with few paths, much shorter than a bake waits for a hidden window.
        assert_eq!(frame(50), Some(false), "frame {k} after the first");
    }
    while frame(1) == Some(false) {}
}

#[test]
fn a_scene_that_is_chosen_is_framed_and_one_that_was_left_keeps_its_camera() {
    let folder = tempfile::tempdir().unwrap();
    let far = folder.path().join("far.obj");
    std::fs::write(&far, "v 100 0 0\nv 101 0 0\nv 100 1 0\nf 1 2 3\n").unwrap();
    let mut harness = open(|_| ());
    settle(&mut harness);
    let near = *harness.state().orbit();
    // As a list or a step back does, and not as a file that is opened.
    for (scene, expected) in [(far.clone(), 100.5), ("built-in:furnace".into(), near.target[0])] {
        harness.state_mut().edits_mut().scene = scene;
        settle(&mut harness);
        let found = harness.state().orbit();
        assert!((found.target[0] - expected).abs() < 1e-6, "{found:?}, expected {expected}");
    }
    // A camera that was left is that of its scene, and not of what stands in for a file that is gone.
    let left = Orbit { distance: 7.0, ..near };
    for (scene, is_kept) in [(far, true), (folder.path().join("gone.obj"), false)] {
        let mut edits = least();
        edits.scene.clone_from(&scene);
        let (mut room, ctx) = (SceneRoom::new(edits, Some(left), UserFolder::none()), Context::default());
        while room.export().is_none() {
            std::thread::sleep(Duration::from_millis(1));
            room.advance(&ctx);
        }
        assert_eq!(*room.orbit() == left, is_kept, "{}: {:?}", scene.display(), room.orbit());
    }
}

#[test]
fn a_change_is_undone_and_made_again() {
    let mut harness = open(|_| ());
    settle(&mut harness);
    harness.run_steps(200);
    harness.get_by_label("Irradiance").click();
    // Undo knows a change once it has rested for a second.
    harness.run_steps(200);
    assert!(harness.state().has_undo(), "there is something to undo");
    harness.state_mut().step(Step::Undo);
    assert_eq!(harness.state().edits().mode, Mode::Interreflected, "undone");
    harness.state_mut().step(Step::Redo);
    assert_eq!(harness.state().edits().mode, Mode::Irradiance, "made again");
}

#[test]
fn files_that_are_none_are_told_in_one_line_and_leave_the_scene_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("broken.glb");
    std::fs::write(&broken, b"glTF nothing of the kind").unwrap();
    let mut harness = open(|_| ());
    settle(&mut harness);
    for (path, word) in [(broken.clone(), "broken.glb"), (folder.path().join("none.hdr"), "none.hdr")] {
        harness.state_mut().open(&path);
        settle(&mut harness);
        let message = harness.state().message().unwrap_or_default().to_owned();
        assert!(message.contains(word) && !message.contains('\n'), "{message}");
        assert!(harness.state().transfer().is_some(), "the scene is still there");
        assert_ne!(harness.state().edits().scene, broken, "and the next start does not fail");
    }
    harness.state_mut().open("notes.txt".as_ref());
    assert!(harness.state().message().is_some_and(|line| line.contains("notes.txt")), "not a file of Lobe");
}

#[test]
fn files_that_are_opened_again_are_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, sky) = (folder.path().join("scene.obj"), folder.path().join("sky.hdr"));
    let write = |more: &str, radiance: f32| {
        std::fs::write(&scene, format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\n{more}")).unwrap();
        let map = EnvMap::from_fn(8, 4, |_| Rgb::new(radiance, radiance, radiance));
        write_env(&sky, &map, &Default::default()).unwrap();
    };
    let found = |harness: &Harness<'_, SceneRoom>| {
        let room = harness.state();
        (room.transfer().unwrap().receivers(), room.sky().unwrap().map.texels()[0].r)
    };
    write("", 1.0);
    let mut harness = open(|edits| (edits.scene, edits.sky) = (scene.clone(), sky.clone()));
    settle(&mut harness);
    let before = found(&harness);
    write("f 2 4 3\n", 2.0);
    settle(&mut harness);
    assert_eq!(found(&harness), before, "nobody asked for what is in the files now");
    harness.state_mut().open(&scene);
    harness.state_mut().open(&sky);
    settle(&mut harness);
    let after = found(&harness);
    assert!(after.0 > before.0 && after.1 > 1.9 * before.1, "{after:?} after {before:?}");
    assert_eq!(harness.state().message(), None, "and nothing went wrong");
}

#[test]
fn what_cannot_be_opened_at_the_start_gives_way_to_the_built_in_sky() {
    let mut harness = open(|edits| edits.sky = "gone.hdr".into());
    settle(&mut harness);
    harness.run_steps(2);
    settle(&mut harness);
    assert!(harness.state().sky().is_some(), "a sky of the program");
    assert_eq!(harness.state().edits().sky, SceneEdits::default().sky, "the first one");
    assert!(harness.state().message().is_some_and(|line| line.contains("gone.hdr")), "and the message remains");
}

#[test]
fn metals_are_made_to_shine_only_where_interreflections_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    let triangle = folder.path().join("triangle.obj");
    std::fs::write(&triangle, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let mut harness = open(|edits| edits.scene = triangle);
    settle(&mut harness);
    let is_there = |harness: &Harness<'_, SceneRoom>| harness.query_by_label("Metals shine").is_some();
    for (mode, expected) in
        [("Irradiance", false), ("Shadowed", false), ("Difference", false), ("Interreflected", true)]
    {
        harness.get_by_label(mode).click();
        harness.run_steps(2);
        assert_eq!(is_there(&harness), expected, "{mode}");
    }
    for expected in [false, true] {
        harness.get_by_label("Metals shine").click();
        harness.run_steps(2);
        assert_eq!(harness.state().edits().has_gloss, expected, "as it was pressed");
    }
}

#[test]
fn materials_take_the_place_of_metals_and_prefilter_the_sky() {
    let folder = tempfile::tempdir().unwrap();
    let triangle = folder.path().join("triangle.obj");
    std::fs::write(&triangle, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let mut harness = open(|edits| (edits.scene, edits.sky) = (triangle, "made:even".into()));
    settle(&mut harness);
    harness.get_by_label("Materials").click();
    harness.run_steps(2);
    settle(&mut harness);
    assert_eq!(harness.state().edits().surfaces, Surfaces::MetallicRoughness, "as it was pressed");
    assert!(harness.query_by_label("Metals shine").is_none(), "metals are among the materials");
    assert_eq!(harness.state().message(), None, "nothing went wrong");
    harness.get_by_label("Materials").click();
    harness.run_steps(2);
    assert_eq!(harness.state().edits().surfaces, Surfaces::Matte, "pressed again");
}

#[test]
fn lamps_are_added_and_removed_by_name() {
    let mut harness = open(|edits| edits.mode = Mode::Irradiance);
    settle(&mut harness);
    harness.get_by_label("Add a sun").click();
    harness.run_steps(2);
    harness.get_by_label("Add a lamp").click();
    harness.run_steps(2);
    assert_eq!(harness.state().edits().lamps.len(), 2, "two lamps");
    harness.get_by_label("Remove lamp 1").click();
    harness.run_steps(2);
    assert_eq!(harness.state().edits().lamps.len(), 1, "one is left");
}

#[test]
fn controls_of_each_lamp_have_names_of_their_own_and_change_that_lamp() {
    let mut harness = open(|edits| edits.lamps = vec![SceneLamp::default(); 2]);
    settle(&mut harness);
    let lamp = SceneLamp::default();
    for what in ["Azimuth", "Height", "Half angle", "Strength"] {
        harness.get_all_by_label(&format!("Lamp 2: {what}")).next().unwrap().focus();
        harness.run_steps(2);
        harness.key_press(Key::ArrowRight);
        harness.run_steps(2);
    }
    let [first, second] = &harness.state().edits().lamps[..] else { panic!("two lamps") };
    let numbers = |lamp: &SceneLamp| [lamp.azimuth, lamp.height, lamp.half_angle, lamp.strength];
    assert_eq!(numbers(first), numbers(&lamp), "the first is as it was");
    let grew = [
        second.azimuth > lamp.azimuth,
        second.height > lamp.height,
        second.half_angle > lamp.half_angle,
        second.strength > lamp.strength,
    ];
    assert_eq!(grew, [true; 4], "the second has more of each: {second:?}");
}

#[test]
fn a_white_surface_that_faces_a_lamp_reflects_its_strength() {
    let mut lamp = SceneLamp::default();
    (lamp.color, lamp.strength, lamp.half_angle) = ([1.0, 0.5, 0.25], 3.0, 10.0);
    for order in 1..=8 {
        let light = lamp.project(order).unwrap();
        let reflected: Rgb<f64> = light.convolved(&Zonal::clamped_cosine(order)).eval(lamp.dir());
        let expected = [3.0, 1.5, 0.75].map(|c| c * std::f64::consts::PI);
        for (found, expected) in <[f64; 3]>::from(reflected).into_iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-9, "order {order}: {found}, expected {expected}");
        }
    }
}

#[test]
fn the_sky_turns_as_its_rotation_says() {
    let mut edits = SceneEdits::default();
    (edits.turn, edits.tilt) = (std::f64::consts::FRAC_PI_2, 0.0);
    let turned = edits.rotation().rotate_dir(Dir::X);
    assert!(turned.angle_to(Dir::Y) < 1e-9, "{turned:?}: a quarter turn about +z brings +x to +y");
}

#[test]
fn every_mode_says_what_it_needs() {
    let of = |mode: BakeMode| (mode == BakeMode::Shadowed).then_some(&*SHADOWED);
    assert!(Mode::Irradiance.transfer(of).unwrap().is_none(), "nothing");
    assert!(Mode::Shadowed.transfer(of).unwrap().is_some(), "one bake");
    assert!(Mode::Difference.transfer(of).unwrap().is_none(), "two, of which one is missing");
    assert_eq!(Mode::Difference.bakes().len(), 2, "its bakes");
    let mean = transfer_of(&SHADOWED, 0).unwrap();
    assert_eq!(mean.coefficients(), [0.5], "the mean of the channels");
    assert!(transfer_of(&SHADOWED, 7).is_none(), "there is no such vertex");
}

static SHADOWED: std::sync::LazyLock<lobe::prt::Transfer> =
    std::sync::LazyLock::new(|| lobe::prt::Transfer::new(1, lobe::prt::Channels::Rgb, vec![0.25, 0.5, 0.75]).unwrap());
