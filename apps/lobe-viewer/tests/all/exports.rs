//! Pictures of the window and of the scene as files.

use std::sync::Arc;

use eframe::egui::{Color32, ColorImage, Event, Key, Modifiers, ScreenshotCallback, ViewportCommand, ViewportId};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use lobe::image::read_picture;
use lobe::io::Job;
use lobe::scene::built_in;
use lobe_gpu::{AdapterChoice, Context, ContextOptions};
use lobe_viewer::{ExportPlan, Kept, Orbit, SceneEdits, SceneRoom, UserFolder, ViewerApp};

use crate::command::viewer;
use crate::wait::step_until;

fn app(folder: &std::path::Path) -> Harness<'static, ViewerApp> {
    let user = UserFolder::at(folder);
    let mut kept = Kept::default();
    (kept.rooms.scene.scene, kept.rooms.scene.order, kept.rooms.scene.samples) = ("built-in:furnace".into(), 1, 16);
    kept.export.folder = folder.into();
    kept.write(&user);
    let app = ViewerApp::new(None, user, &[]);
    Harness::builder().with_size([1280.0, 800.0]).build_ui_state(|ui, app: &mut ViewerApp| app.show(ui), app)
}

/// Steps until the notice says something.
fn notice(harness: &mut Harness<'_, ViewerApp>) -> String {
    step_until(harness, |app| app.notice().is_some());
    harness.state().notice().unwrap().to_owned()
}

/// Presses a key in the next frame alone: of the frames of a step only the last is seen.
fn press(harness: &mut Harness<'_, ViewerApp>, key: Key) {
    let (pressed, repeat, modifiers) = (true, false, Modifiers::NONE);
    harness.input_mut().events.push(Event::Key { key, physical_key: None, pressed, repeat, modifiers });
}

/// The pictures of the window that it asked for in the last frame.
fn asked(harness: &Harness<'_, ViewerApp>) -> Vec<ScreenshotCallback> {
    let commands = &harness.output().viewport_output[&ViewportId::ROOT].commands;
    let asked = commands.iter().filter_map(|command| match command {
        ViewportCommand::Screenshot(callback) => Some(callback.clone()),
        _ => None,
    });
    asked.collect()
}

/// Gives the window this picture as often as it asks for one in the next steps, and says how often that was.
fn answered(harness: &mut Harness<'_, ViewerApp>, image: &Arc<ColorImage>) -> usize {
    let mut count = 0;
    for _ in 0..4 {
        harness.step();
        count += asked(harness).into_iter().map(|callback| callback.complete(image.clone())).count();
    }
    count
}

#[test]
fn the_window_is_written_byte_for_byte_by_its_button_and_by_its_key_in_every_room() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = app(folder.path());
    harness.run_steps(3);
    let pixels = (0..=255_u8).map(|b| Color32::from_rgb(b, 255 - b, b / 2)).collect();
    let image = Arc::new(ColorImage::new([64, 4], pixels));
    for (number, key) in [(1, None), (2, Some(Key::Num2)), (3, Some(Key::Num3)), (4, Some(Key::Num4))] {
        match key {
            None => harness.get_by_label("Screenshot").click(),
            Some(room) => {
                harness.key_press_modifiers(Modifiers::COMMAND, room);
                harness.run_steps(2);
                press(&mut harness, Key::F12);
            }
        }
        assert_eq!(answered(&mut harness, &image), 1, "picture {number}: asked for once");
        let path = folder.path().join(format!("lobe-window-{number:04}.png"));
        step_until(&mut harness, |_| path.exists());
        let said = notice(&mut harness);
        assert!(said.starts_with("Written: "), "{said}");
        let (read, _) = read_picture(&path, &Default::default()).unwrap();
        let bytes = lobe::image::Tone::PLAIN.to_bytes(&read);
        let expected: Vec<u8> = image.pixels.iter().flat_map(|c| [c.r(), c.g(), c.b()]).collect();
        assert_eq!(bytes, expected, "picture {number}");
    }
}

#[test]
fn two_pictures_of_the_window_in_one_moment_are_two_files() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = app(folder.path());
    harness.run_steps(3);
    let colors = [Color32::RED, Color32::BLUE];
    let mut callbacks = Vec::new();
    for _ in colors {
        press(&mut harness, Key::F12);
        harness.step();
        callbacks.extend(asked(&harness));
    }
    assert_eq!(callbacks.len(), 2, "asked for twice");
    for (callback, color) in callbacks.into_iter().zip(colors) {
        callback.complete(Arc::new(ColorImage::filled([3, 2], color)));
    }
    let paths = [1, 2].map(|number| folder.path().join(format!("lobe-window-{number:04}.png")));
    let last = format!("Written: {}", paths[1].display());
    step_until(&mut harness, |app| app.notice() == Some(last.as_str()));
    for (path, color) in paths.iter().zip(colors) {
        let (read, _) = read_picture(path, &Default::default()).unwrap();
        let expected = [color.r(), color.g(), color.b()].repeat(6);
        assert_eq!(lobe::image::Tone::PLAIN.to_bytes(&read), expected, "{}", path.display());
    }
}

#[test]
fn a_fresh_start_goes_on_with_what_is_being_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = app(folder.path());
    harness.run_steps(3);
    harness.get_by_label("File").click();
    harness.run_steps(3);
    press(&mut harness, Key::F12);
    harness.step();
    let callbacks = asked(&harness);
    assert_eq!(callbacks.len(), 1, "asked for once");
    let image = Arc::new(ColorImage::filled([3, 2], Color32::RED));
    callbacks.into_iter().for_each(|callback| callback.complete(image.clone()));
    harness.get_by_label("Start afresh").click();
    let path = folder.path().join("lobe-window-0001.png");
    let said = format!("Written: {}", path.display());
    step_until(&mut harness, |app| app.notice() == Some(said.as_str()));
    assert!(path.exists(), "{}", path.display());
    assert_eq!(harness.state().scene().edits().scene, SceneEdits::default().scene, "as at the first start");
}

#[test]
fn a_folder_that_is_none_is_told_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = app(folder.path());
    harness.state_mut().export_plan_mut().folder = folder.path().join("gone");
    harness.run_steps(2);
    press(&mut harness, Key::F12);
    let image = Arc::new(ColorImage::filled([2, 2], Color32::RED));
    assert_eq!(answered(&mut harness, &image), 1, "asked for once");
    let said = notice(&mut harness);
    assert!(said.contains("gone") && said.contains("Export") && said.lines().count() == 1, "{said}");
}

#[test]
fn without_a_device_the_scene_is_not_exported_and_its_buttons_are_off() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = app(folder.path());
    harness.run_steps(2);
    harness.get_by_label("Export").click();
    harness.run_steps(4);
    for name in ["Picture", "Turntable"] {
        let is_off = harness.get_all_by_label(name).any(|node| node.accesskit_node().is_disabled());
        assert!(is_off, "{name}");
    }
}

fn room() -> Harness<'static, SceneRoom> {
    let mut edits = SceneEdits::default();
    edits.scene = "built-in:ball".into();
    edits.sky = "made:evening".into();
    (edits.order, edits.turn) = (2, 0.0);
    let bounds = built_in::named("ball").unwrap().world_bounds();
    let (azimuth, height) = (-62.0_f64.to_radians(), 9.0_f64.to_radians());
    let mut orbit = Orbit::default();
    (orbit.azimuth, orbit.height) = (azimuth, height);
    let room = SceneRoom::new(edits, Some(orbit.framing(bounds)), UserFolder::none());
    let show = |ui: &mut eframe::egui::Ui, room: &mut SceneRoom| {
        room.advance(ui.ctx());
        room.ui(ui, None);
    };
    let mut harness = Harness::builder().with_size([1100.0, 900.0]).build_ui_state(show, room);
    settle(&mut harness);
    harness
}

/// Steps until nothing is being opened or baked.
fn settle(harness: &mut Harness<'_, SceneRoom>) {
    harness.run_steps(2);
    step_until(harness, SceneRoom::is_idle);
}

#[test]
#[ignore = "long: of the nightly group"]
fn a_turntable_of_the_window_is_that_of_the_command_and_one_that_is_cancelled_is_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let Ok(context) = Context::new(&ContextOptions::default().adapter(AdapterChoice::Software)) else {
        lobe_testkit::skipped("turntables of lobe-viewer: no graphics adapter");
        return;
    };
    let mut harness = room();
    let export = harness.state_mut().export().unwrap();
    let mut plan = ExportPlan::default();
    (plan.size, plan.rays) = ([48, 30], 2);
    for frames in [1, 3] {
        let (own, headless) = (folder.path().join("own.png"), folder.path().join("headless.png"));
        export.write(&context, &plan, frames, &own, Job::default()).unwrap();
        let arguments = format!(
            "--headless built-in:ball --env made:evening --order 2 --samples 256 --size 48x30 --rays 2 \
             --frames {frames} --software -o headless.png"
        );
        let output = viewer(folder.path(), &arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(std::fs::read(own).unwrap(), std::fs::read(headless).unwrap(), "{frames} frames");
    }
    let stopped = folder.path().join("stopped.png");
    let mut watch = |progress: &lobe::io::Progress| match progress.done {
        1 => std::ops::ControlFlow::Break(()),
        _ => std::ops::ControlFlow::Continue(()),
    };
    let job = Job::default().watched_by(&mut watch);
    assert!(export.write(&context, &plan, 3, &stopped, job).is_err(), "told to stop after one of three");
    assert!(!stopped.exists(), "nothing half-written has the name");
}

#[test]
#[ignore = "long: of the nightly group"]
fn lamps_stay_where_they_are_while_a_turntable_turns_the_sky() {
    let folder = tempfile::tempdir().unwrap();
    let Ok(context) = Context::new(&ContextOptions::default().adapter(AdapterChoice::Software)) else {
        lobe_testkit::skipped("lamps of turntables of lobe-viewer: no graphics adapter");
        return;
    };
    let mut harness = room();
    harness.state_mut().edits_mut().sky = "made:even".into();
    settle(&mut harness);
    let mut plan = ExportPlan::default();
    (plan.size, plan.rays) = ([24, 16], 1);
    let frames = |harness: &mut Harness<'_, SceneRoom>, name: &str| -> Vec<Vec<[f32; 3]>> {
        let export = harness.state_mut().export().unwrap();
        export.write(&context, &plan, 2, &folder.path().join(format!("{name}.exr")), Job::default()).unwrap();
        let frame = |number: usize| folder.path().join(format!("{name}.{number:04}.exr"));
        (0..2).map(|number| read_picture(frame(number), &Default::default()).unwrap().0.into_pixels()).collect()
    };
    // A sky that is even everywhere looks the same in every turn.
    let without = frames(&mut harness, "even");
    harness.state_mut().edits_mut().lamps = vec![lobe_viewer::SceneLamp::default()];
    let with = frames(&mut harness, "lamp");
    assert!(difference(&with[0], &without[0]) > 0.05, "the lamp shows");
    assert!(difference(&with[0], &with[1]) < 1e-4, "after half a turn: {}", difference(&with[0], &with[1]));
}

fn difference(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}
