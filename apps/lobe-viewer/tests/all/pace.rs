//! Time in the rooms: as fast at many frames a second as at few.

use eframe::egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use lobe_viewer::{MotionEdits, MotionRoom, ReadLimits, SkyEdits, SkyRoom, open_sky};

use crate::wait::step_until;

/// Frames a second of a quick display.
const QUICK: usize = 144;

/// Passed time may be wrong by one frame at each end.
const WITHIN: f64 = 2.5 / QUICK as f64;

#[test]
fn the_sky_keeps_turning_however_short_a_frame_is() {
    let sky = open_sky("made:even".as_ref(), &ReadLimits::default()).unwrap();
    let mut edits = SkyEdits::default();
    (edits.order, edits.lights, edits.has_expansion) = (1, 0, true);
    let show = move |ui: &mut eframe::egui::Ui, room: &mut SkyRoom| room.ui(ui, Some(&sky));
    let builder = Harness::builder().with_size([360.0, 900.0]).with_step_dt(1.0 / QUICK as f32);
    let mut harness = builder.build_ui_state(show, SkyRoom::new(edits));
    harness.run_steps(2);
    harness.get_by_label("Keep turning (T)").click();
    harness.run_steps(2);
    let before = harness.state().edits().turn;
    harness.run_steps(QUICK / 12);
    let turned = harness.state().edits().turn - before;
    // Half a radian a second.
    assert!((turned - 0.5 / 12.0).abs() < 0.5 * WITHIN, "{turned} in a twelfth of a second");
}

#[test]
fn an_animation_plays_in_its_own_time_however_short_a_frame_is() {
    let folder = tempfile::tempdir().unwrap();
    let mut room = MotionRoom::new(MotionEdits::default());
    room.open(&crate::motion::described(folder.path()));
    let sky = open_sky("made:even".as_ref(), &ReadLimits::default()).unwrap();
    let show = move |ui: &mut eframe::egui::Ui, room: &mut MotionRoom| room.ui(ui, None, Some(&sky));
    let builder = Harness::builder().with_size([700.0, 1400.0]).with_step_dt(1.0 / QUICK as f32);
    let mut harness = builder.build_ui_state(show, room);
    step_until(&mut harness, MotionRoom::is_ready);
    let time = |harness: &Harness<'_, MotionRoom>| {
        harness.get_by_role_and_label(Role::Slider, "Time").accesskit_node().numeric_value().unwrap()
    };
    harness.run_steps(1);
    let before = time(&harness);
    harness.run_steps(QUICK / 4);
    // It comes around after two seconds.
    let passed = (time(&harness) - before).rem_euclid(2.0);
    assert!((passed - 0.25).abs() < WITHIN, "{passed} in a quarter of a second");
}
