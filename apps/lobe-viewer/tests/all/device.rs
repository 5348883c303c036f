//! The window on a device that goes away, and in sizes that show nothing.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use eframe::egui::{Key, Shape, TextureId, ViewportCommand, ViewportId};
use eframe::egui_wgpu::{RenderState, RendererOptions, WgpuConfiguration};
use eframe::wgpu;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lobe_viewer::{
    Comparison, Gpu, Kept, Mode, MotionEdits, MotionRoom, MotionView, ReadLimits, RoomName, SceneEdits, SceneRoom,
    UserFolder, ViewerApp, open_sky,
};

use crate::wait::step_until;

/// A device as a window opens it; none, and one line that says so, on a machine without an adapter.
fn device(test: &str) -> Option<RenderState> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let config = WgpuConfiguration::default();
    let opened = pollster::block_on(RenderState::create(&config, &instance, None, RendererOptions::default()));
    if opened.is_err() {
        lobe_testkit::skipped(&format!("{test} of lobe-viewer: no graphics adapter"));
    }
    opened.ok()
}

fn open(gpu: &Gpu, room: RoomName, lost: &Arc<AtomicBool>) -> Harness<'static, ViewerApp> {
    let folder = tempfile::tempdir().unwrap();
    let user = UserFolder::at(folder.path());
    let mut kept = Kept::default();
    (kept.rooms.scene.scene, kept.rooms.scene.order, kept.room) = ("built-in:furnace".into(), 1, room);
    kept.rooms.scene.samples = 16;
    kept.write(&user);
    let app = ViewerApp::new(Some(gpu.clone()), user, &[]).reporting_loss_to(lost.clone());
    let mut harness =
        Harness::builder().with_size([800.0, 600.0]).build_ui_state(|ui, app: &mut ViewerApp| app.show(ui), app);
    step_until(&mut harness, |app| app.scene().is_idle());
    harness
}

/// The lines of text in the last frame.
fn texts(harness: &Harness<'_, ViewerApp>) -> usize {
    harness.output().shapes.iter().filter(|shape| matches!(shape.shape, Shape::Text(_))).count()
}

#[test]
fn a_window_whose_device_is_lost_draws_nothing_closes_and_says_so_in_every_room() {
    for room in RoomName::ALL {
        let Some(state) = device("a window whose device is lost") else { return };
        let (gpu, lost) = (Gpu::of_window(&state), Arc::new(AtomicBool::new(false)));
        let mut harness = open(&gpu, room, &lost);
        harness.run_steps(2);
        assert!(!lost.load(Ordering::Relaxed) && texts(&harness) > 5, "{room:?}: it is shown");
        state.device.destroy();
        // The loss is reported when the device has done what it was given before.
        while !lost.load(Ordering::Relaxed) {
            harness.step();
        }
        let output = harness.output();
        let asks = &output.viewport_output[&ViewportId::ROOT].commands;
        assert!(asks.contains(&ViewportCommand::Close), "{room:?}: the window closes");
        // The library of the window panics on triangles without a device. The background is the harness's own.
        assert_eq!(texts(&harness), 0, "{room:?}: nothing is drawn");
    }
}

#[test]
fn pictures_stand_windows_without_pixels_and_come_back() {
    for room in [RoomName::Scene, RoomName::Motion] {
        let Some(state) = device("windows without pixels") else { return };
        let (gpu, lost) = (Gpu::of_window(&state), Arc::new(AtomicBool::new(false)));
        let mut harness = open(&gpu, room, &lost);
        for size in [[0.0, 0.0], [1.0, 1.0], [800.0, 0.0], [0.0, 600.0], [5000.0, 2.0], [800.0, 600.0]] {
            harness.set_size(size.into());
            harness.run_steps(3);
            assert!(gpu.context().check().is_ok(), "{room:?} at {size:?}: the device refused nothing");
        }
        assert!(!lost.load(Ordering::Relaxed), "{room:?}: it is still there");
    }
}

#[test]
fn a_fresh_start_gives_the_pictures_back_that_were_shown() {
    let Some(state) = device("a fresh start") else { return };
    let (gpu, lost) = (Gpu::of_window(&state), Arc::new(AtomicBool::new(false)));
    let mut harness = open(&gpu, RoomName::Scene, &lost);
    harness.run_steps(2);
    let is_there = || state.renderer.read().texture(&TextureId::User(0)).is_some();
    assert!(is_there(), "the picture of the scene");
    harness.get_by_label("File").click();
    harness.run_steps(3);
    harness.get_by_label("Start afresh").click();
    harness.run_steps(1);
    assert!(!is_there(), "the device has it no longer");
    assert!(gpu.context().check().is_ok(), "the device refused nothing");
}

#[test]
#[ignore = "long: of the nightly group"]
fn both_ways_are_shown_beside_the_truth_with_their_distance_from_it() {
    let Some(state) = device("what moves beside its truth") else { return };
    let gpu = Gpu::of_window(&state);
    let mut room = MotionRoom::new(MotionEdits::default());
    room.pause_at(0.5);
    room.edits_mut().view = MotionView::Beside;
    let sky = open_sky("made:noon".as_ref(), &ReadLimits::default()).unwrap();
    let show = |ui: &mut eframe::egui::Ui, room: &mut MotionRoom| room.ui(ui, Some(&gpu), Some(&sky));
    let mut harness = Harness::builder().with_size([700.0, 900.0]).build_ui_state(show, room);
    let ways = [MotionView::Fields, MotionView::Exponentials];
    step_until(&mut harness, |room| ways.iter().all(|way| room.error(*way).is_some()));
    // The panel says in a frame what the one before has found.
    let errors = ways.map(|way| harness.state().error(way).unwrap());
    harness.run_steps(1);
    for (way, error) in ways.into_iter().zip(errors) {
        // Two paths a pixel are noisy; what is shadowed by another thing altogether would be farther.
        assert!(error > 0.0 && error < 1.0, "{way:?}: {error}");
        let text = format!("{}: {:.1} % from the truth", way.title(), 100.0 * error);
        assert!(harness.query_by_label(&text).is_some(), "{text}");
    }
    harness.key_press(Key::Num1);
    harness.run_steps(2);
    assert_eq!(harness.state().edits().view, MotionView::Fields, "one picture by its key");
    assert!(gpu.context().check().is_ok(), "the device refused nothing");
}

/// The distance of a plain ground from its truth under a sky, as soon as it is near enough.
fn distance_of_ground(gpu: &Gpu, sky: &str, order: usize, is_enough: impl Fn(f64) -> bool) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let ground = folder.path().join("ground.obj");
    std::fs::write(&ground, "v -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2\nf 1 2 3\nf 1 3 4\n").unwrap();
    let mut edits = SceneEdits::default();
    (edits.scene, edits.sky, edits.order, edits.mode) = (ground, sky.into(), order, Mode::Irradiance);
    // The expansion holds all light.
    edits.has_suns = false;
    let room = SceneRoom::new(edits, None, UserFolder::none());
    let show = |ui: &mut eframe::egui::Ui, room: &mut SceneRoom| {
        room.advance(ui.ctx());
        room.ui(ui, Some(gpu));
    };
    // So narrow that the line of times wraps, now into more lines, now into fewer.
    let mut harness = Harness::builder().with_size([400.0, 700.0]).build_ui_state(show, room);
    harness.run_steps(2);
    step_until(&mut harness, SceneRoom::is_idle);
    harness.get_by_label("Difference to the truth").click();
    harness.run_steps(2);
    assert_eq!(harness.state().edits().comparison, Comparison::Difference, "it was pressed");
    step_until(&mut harness, |room| room.error().is_some_and(&is_enough));
    // The panel says in a frame what the one before has found.
    let known = harness.state().error();
    harness.run_steps(1);
    let said = |error: f64| format!("RMS difference {:.1} % of the mean", 100.0 * error);
    let is_said =
        known.iter().chain(&harness.state().error()).any(|e| harness.query_by_label_contains(&said(*e)).is_some());
    assert!(is_said, "{known:?} and {:?}", harness.state().error());
    known.unwrap()
}

#[test]
#[ignore = "long: of the nightly group"]
fn the_difference_to_the_truth_vanishes_where_the_light_has_no_more_bands_than_are_kept() {
    let Some(state) = device("a scene beside its truth") else { return };
    let gpu = Gpu::of_window(&state);
    // An even sky is its first band: what is left is the noise of the paths, which falls.
    let even = distance_of_ground(&gpu, "made:even", 1, |error| error < 0.04);
    // Of a sun nothing is left in one band.
    let sun = distance_of_ground(&gpu, "made:noon", 1, |_| true);
    assert!(sun > 0.2 && even < 0.04, "{sun} and {even}");
    assert!(gpu.context().check().is_ok(), "the device refused nothing");
}
