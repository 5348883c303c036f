//! The mouse on the pictures of each room: the camera and the sky follow it.

use eframe::egui::{Modifiers, PointerButton, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lobe_viewer::{FunctionsEdits, FunctionsRoom, Orbit, ReadLimits, Section, Shape, SkyEdits, open_sky};

use crate::press::{drag, scroll};
use crate::sky::open_in;

/// Whether two cameras are the same to the rounding of points and of files.
pub(crate) fn are_close(a: &Orbit, b: &Orbit) -> bool {
    let numbers = |o: &Orbit| [o.azimuth, o.height, o.distance, o.target[0], o.target[1], o.target[2]];
    numbers(a).into_iter().zip(numbers(b)).all(|(a, b)| (a - b).abs() < 1e-5)
}

#[test]
fn a_drag_turns_the_view_moves_it_with_ctrl_or_the_right_button_and_turns_the_sky_with_shift() {
    let sky = open_sky("made:even".as_ref(), &ReadLimits::default()).unwrap();
    let mut edits = SkyEdits::default();
    (edits.order, edits.lights, edits.has_expansion) = (1, 0, true);
    let mut harness = open_in([500.0, 1500.0], edits, Some(sky));
    let rect = harness.get_by_label("The sky with a mirror, a glossy and a matte ball").rect();
    let (from, by) = (rect.center(), vec2(60.0, -30.0));
    let [right, down] = [by.x, by.y].map(|points| f64::from(points / rect.height()));
    let mut expected = *harness.state().room.orbit();
    drag(&mut harness, from, by, (PointerButton::Primary, Modifiers::NONE));
    expected.turn(right, down);
    assert!(are_close(harness.state().room.orbit(), &expected), "{:?}, {expected:?}", harness.state().room.orbit());
    drag(&mut harness, from, by, (PointerButton::Primary, Modifiers::COMMAND));
    expected.pan(right, down);
    assert!(are_close(harness.state().room.orbit(), &expected), "{:?}, {expected:?}", harness.state().room.orbit());
    drag(&mut harness, from, by, (PointerButton::Secondary, Modifiers::NONE));
    expected.pan(right, down);
    assert!(are_close(harness.state().room.orbit(), &expected), "{:?}, {expected:?}", harness.state().room.orbit());
    let before = [harness.state().room.edits().turn, harness.state().room.edits().tilt];
    assert_eq!(before, [0.0; 2], "the sky stood still");
    drag(&mut harness, from, by, (PointerButton::Primary, Modifiers::SHIFT));
    let edits = harness.state().room.edits();
    let half_turns = [edits.turn, edits.tilt].map(|angle| angle / std::f64::consts::PI);
    assert!((half_turns[0] - right).abs() < 1e-6 && (half_turns[1] - down).abs() < 1e-6, "{half_turns:?}");
    assert!(are_close(harness.state().room.orbit(), &expected), "and the view stayed");
}

#[test]
fn the_wheel_comes_nearer_over_a_picture_and_not_over_the_panel() {
    let mut edits = FunctionsEdits::default();
    (edits.order, edits.shape, edits.has_crosses, edits.section) = (2, Shape::Basis(1, 0), false, Section::None);
    let room = FunctionsRoom::new(edits);
    let show = |ui: &mut eframe::egui::Ui, room: &mut FunctionsRoom| room.ui(ui);
    let mut harness = Harness::builder().with_size([800.0, 1000.0]).build_ui_state(show, room);
    harness.run_steps(2);
    let balloon = harness.get_by_label("Balloon of f").rect().center();
    let mut expected = *harness.state().orbit();
    for points in [40.0, -90.0] {
        scroll(&mut harness, balloon, points);
        expected.scroll(f64::from(points));
        let distance = harness.state().orbit().distance;
        assert!((distance / expected.distance - 1.0).abs() < 1e-4, "{distance}, expected {}", expected.distance);
    }
    let before = *harness.state().orbit();
    let beside = harness.get_by_label("Frame").rect().center();
    scroll(&mut harness, beside, 40.0);
    assert_eq!(*harness.state().orbit(), before, "over the panel the view stays");
}
