//! Numbers of the room of motion beside those of the library: parts moved by hand, spheres by each fit, changes taken back.

use eframe::egui::Key;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use lobe::io::Job;
use lobe::motion::{Motion, MovingMethod, MovingOptions, MovingScene, MovingShading};
use lobe::sh::{Dir, Expansion as _, Rgb, Rotation};
use lobe::shadow::{Placement, SphereFitMethod, Track};
use lobe_viewer::{MotionRoom, ReadLimits, Step, moving_bake_options, open_moving};

use crate::motion::{described, open, wait};
use crate::press::slide;

#[test]
fn a_part_that_is_put_somewhere_by_sliders_is_lit_as_the_library_lights_it_there() {
    let folder = tempfile::tempdir().unwrap();
    let source = described(folder.path());
    let mut harness = open(&source);
    harness.state_mut().room.pause_at(0.0);
    wait(&mut harness, |room| room.radiance(MovingMethod::Fields).is_some());
    let before = harness.state().room.radiance(MovingMethod::Fields).unwrap().to_vec();
    // The progress of bakes above moves what is below it: a pointer might miss.
    harness.get_by_label("Move objects by hand").click_accesskit();
    harness.run_steps(2);
    for (slider, value) in [("x", 0.5), ("y", -0.25), ("z", 1.5), ("Turn", 90.0), ("Size", 1.25)] {
        slide(&mut harness, slider, value);
    }
    let mut scene = open_moving(&source, &ReadLimits::default()).unwrap();
    scene
        .bake(MovingMethod::Fields, &moving_bake_options(4, SphereFitMethod::Variational, 16, true), Job::default())
        .unwrap();
    let turn = Rotation::from_axis_angle(Dir::Z, 90.0_f64.to_radians());
    let parts = scene.parts().iter().cloned().map(|mut part| {
        if !matches!(part.motion, Motion::Still) {
            part.motion = Motion::Track(Track::resting(Placement::new([0.5, -0.25, 1.5], turn, 1.25)));
        }
        part
    });
    let placed = MovingScene::new(parts.collect()).unwrap();
    let shading = MovingShading::new(MovingOptions::default().order(4).method(MovingMethod::Fields)).unwrap();
    let light = harness.state().room.light().unwrap().clone();
    let expected = shading.exit_radiance(&placed.at(0.0).unwrap(), &light).unwrap();
    assert_ne!(expected, before, "it is somewhere else");
    wait(&mut harness, |room| room.radiance(MovingMethod::Fields) == Some(&expected[..]));
    harness.get_by_label("Put back").click_accesskit();
    // Where it was is known to the rounding of its vertices.
    let are_close = |found: &[Rgb<f32>]| {
        let apart = |(a, b): (&Rgb<f32>, &Rgb<f32>)| {
            (*a - *b).to_array().into_iter().fold(0.0_f32, |most, c| most.max(c.abs()))
        };
        found.iter().zip(&before).all(|pair| apart(pair) < 1e-5)
    };
    wait(&mut harness, |room| room.radiance(MovingMethod::Fields).is_some_and(are_close));
}

#[test]
#[ignore = "long: of the nightly group"]
fn spheres_of_the_other_fit_are_those_of_the_library_and_undo_brings_the_first_ones_back() {
    let folder = tempfile::tempdir().unwrap();
    let source = described(folder.path());
    let mut harness = open(&source);
    harness.state_mut().room.pause_at(0.0);
    wait(&mut harness, MotionRoom::is_ready);
    let is_off = harness.get_by_label("Medial axis").accesskit_node().is_disabled();
    assert!(is_off, "fields need no spheres");
    harness.get_by_label("Spheres, SH exponentials").click();
    let way = MovingMethod::Exponentials;
    wait(&mut harness, |room| room.radiance(way).is_some());
    // Undo knows a change once it has rested for a second.
    harness.run_steps(10);
    let light = harness.state().room.light().unwrap().clone();
    let expected = [SphereFitMethod::Variational, SphereFitMethod::MedialAxis].map(|fit| {
        let mut scene = open_moving(&source, &ReadLimits::default()).unwrap();
        scene.bake(way, &moving_bake_options(4, fit, 16, true), Job::default()).unwrap();
        let shading = MovingShading::new(MovingOptions::default().order(4).method(way)).unwrap();
        shading.exit_radiance(&scene.at(0.0).unwrap(), &light).unwrap()
    });
    assert_ne!(expected[0], expected[1], "two fits");
    wait(&mut harness, |room| room.radiance(way) == Some(&expected[0][..]));
    harness.get_by_label("Medial axis").click();
    wait(&mut harness, |room| room.radiance(way) == Some(&expected[1][..]));
    harness.run_steps(10);
    harness.state_mut().room.step(Step::Undo);
    wait(&mut harness, |room| room.radiance(way) == Some(&expected[0][..]));
    harness.state_mut().room.step(Step::Redo);
    wait(&mut harness, |room| room.radiance(way) == Some(&expected[1][..]));
    assert_eq!(harness.state().room.message(), None, "and nothing went wrong");
}

#[test]
fn a_key_that_changed_the_light_is_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = open(&described(folder.path()));
    harness.state_mut().room.pause_at(0.0);
    wait(&mut harness, MotionRoom::is_ready);
    harness.run_steps(10);
    let before = harness.state().room.edits().clone();
    harness.key_press(Key::Comma);
    wait(&mut harness, |room| room.light().is_some_and(|light| light.order() == 3));
    harness.run_steps(10);
    harness.state_mut().room.step(Step::Undo);
    assert_eq!(*harness.state().room.edits(), before, "the order of before");
    wait(&mut harness, |room| room.light().is_some_and(|light| light.order() == 4));
}
