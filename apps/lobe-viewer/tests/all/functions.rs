//! The room of functions: what is pressed, and what is shown.

use eframe::egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lobe::sh::{AmbientCube, Dir, Expansion as _, ShL2, Zonal, certified_minimum, convolved, product};
use lobe_viewer::{FunctionsEdits, FunctionsRoom, Shape, Study, Taming};

/// Frames after which a room that shows its pictures one after the other is at rest, on any machine.
const STEPS: u64 = 500;

fn open(edits: FunctionsEdits) -> Harness<'static, FunctionsRoom> {
    let room = FunctionsRoom::new(edits);
    let mut harness = Harness::builder()
        .with_size([1200.0, 1500.0])
        .with_max_steps(STEPS)
        .build_ui_state(|ui, room: &mut FunctionsRoom| room.ui(ui), room);
    harness.run();
    harness
}

fn edits(change: impl FnOnce(&mut FunctionsEdits)) -> FunctionsEdits {
    let mut edits = FunctionsEdits::default();
    change(&mut edits);
    edits
}

/// Goes to a control by its name and presses a key there.
fn press(harness: &mut Harness<'_, FunctionsRoom>, name: &str, key: Key) {
    harness.get_all_by_label(name).next().unwrap().focus();
    harness.run();
    harness.key_press(key);
    harness.run();
}

#[test]
fn turning_a_slider_shows_the_coefficients_of_the_turned_function() {
    let mut harness = open(edits(|edits| edits.shape = Shape::Basis(2, 1)));
    press(&mut harness, "Yaw", Key::ArrowRight);
    let edits = harness.state().edits().clone();
    assert_ne!(edits.angles[0], FunctionsEdits::default().angles[0], "the key moved the slider");
    let turned = edits.rotation().rotated(&edits.function());
    for (l, energy) in turned.band_energies().iter().enumerate() {
        let row: Vec<String> = turned.band(l).iter().map(|c| format!("{c:8.4}")).collect();
        let text = format!("band {l}: {}   energy {energy:.4}", row.join(" "));
        assert!(harness.query_by_label(&text).is_some(), "{text}");
    }
}

#[test]
fn the_energy_that_a_product_loses_is_that_of_the_library() {
    let mut harness = open(edits(|edits| (edits.shape, edits.other) = (Shape::Lobe(20.0), Shape::Cosine)));
    harness.get_by_label("Product").click();
    harness.run();
    assert_eq!(harness.state().edits().study, Study::Product, "the study that was pressed");
    let edits = harness.state().edits();
    let (f, g) = (edits.function(), edits.other_factor());
    let (kept, all) = (product(&f, &g, edits.order), product(&f, &g, 2 * edits.order - 1));
    let lost = 100.0 * (1.0 - kept.dot(&kept) / all.dot(&all));
    let text = format!("Energy cut off with the bands above: {lost:.2} %");
    assert!(lost > 0.1 && harness.query_by_label(&text).is_some(), "{text}");
}

#[test]
fn the_minimum_that_is_shown_is_certified_and_dering_ends_it() {
    let mut harness = open(edits(|edits| edits.study = Study::Ringing));
    press(&mut harness, "Half angle of the light", Key::ArrowRight);
    let light = harness.state().edits().ringing_light();
    let found = certified_minimum(light.coefficients(), 1e-9);
    let at = found.dir.theta().to_degrees();
    let text = format!("Minimum: {:.5}, {at:.0}° from the axis", found.lo);
    assert!(found.lo < -0.01 && harness.query_by_label(&text).is_some(), "{text}");
    let harness = open(edits(|edits| (edits.study, edits.taming) = (Study::Ringing, Taming::Dering)));
    let tamed = Taming::Dering.tamed_gray(&harness.state().edits().ringing_light());
    let least = certified_minimum(tamed.coefficients(), 1e-9);
    assert!(least.lo > -1e-6, "{least:?}");
    let at = least.dir.theta().to_degrees();
    let text = format!("Minimum, tamed: {:.5}, {at:.0}° from the axis", least.lo);
    assert!(harness.query_by_label(&text).is_some(), "{text}");
}

#[test]
fn the_cube_wobbles_by_what_is_shown() {
    let mut harness = open(edits(|edits| edits.study = Study::AmbientCube));
    press(&mut harness, "Azimuth of the light", Key::ArrowRight);
    let edits = harness.state().edits();
    let light = Dir::from_angles(std::f64::consts::FRAC_PI_2, edits.light_at.to_radians());
    let irradiance = convolved(&ShL2::impulse(light, 1.0), &Zonal::clamped_cosine(3));
    let cube: f64 = AmbientCube::from_irradiance_sh(&irradiance).eval(light);
    let text = format!("Facing the light: {:.4} by coefficients, {cube:.4} by the cube", irradiance.eval(light));
    assert!(harness.query_by_label(&text).is_some(), "{text}");
    assert!(f64::abs(irradiance.eval(light) - cube) > 0.01, "{text}");
}

#[test]
fn every_study_shows_its_balloons_under_their_names() {
    for (study, names) in [
        (Study::Rotate, &["Balloon of f", "Unfolded cube of f turned", "Polar plot of f turned, x and z"][..]),
        (Study::Product, &["Balloon of f", "Balloon of g", "Balloon of f g", "Polar plot of f g, x and z"]),
        (Study::Ringing, &["Balloon of the light", "Radiance by the angle from the axis"]),
        (
            Study::AmbientCube,
            &[
                "Irradiance by an ambient cube",
                "Unfolded cube of Ambient cube",
                "Irradiance facing the light, by its azimuth",
            ],
        ),
    ] {
        let harness = open(edits(|edits| edits.study = study));
        for name in names {
            assert!(harness.query_by_label(name).is_some(), "{study:?}: {name}");
        }
    }
}

#[test]
fn a_function_of_the_basis_has_one_coefficient_whatever_is_kept_of_it() {
    for (l, m) in [(0, 0), (2, -1), (3, 3), (2, 9), (3, isize::MAX), (9, 0)] {
        let f = Shape::Basis(l, m).expansion(4, Dir::Z);
        let count = f.coefficients().iter().filter(|c| **c != 0.0).count();
        assert_eq!(count, usize::from(l < 4), "band {l}, number {m}");
    }
}

#[test]
fn keys_turn_the_function_and_come_nearer_and_frame_goes_back() {
    let mut harness = open(edits(|edits| (edits.shape, edits.angles) = (Shape::Basis(2, 1), [0.0; 3])));
    let before = *harness.state().orbit();
    harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowRight);
    harness.run();
    harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowDown);
    harness.run();
    let edits = harness.state().edits().clone();
    for (found, expected) in edits.angles.into_iter().zip([5.0, 0.0, 5.0]) {
        assert!((found - expected).abs() < 1e-9, "{:?}", edits.angles);
    }
    let turned = edits.rotation().rotated(&edits.function());
    let row: Vec<String> = turned.band(2).iter().map(|c| format!("{c:8.4}")).collect();
    let text = format!("band 2: {}   energy {:.4}", row.join(" "), turned.band_energies()[2]);
    assert!(harness.query_by_label(&text).is_some(), "{text}");
    harness.key_press(Key::Plus);
    harness.run();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::ArrowRight);
    harness.run();
    let orbit = *harness.state().orbit();
    assert!(orbit.distance < before.distance && orbit.target != before.target, "nearer and moved: {orbit:?}");
    harness.key_press(Key::F);
    harness.run();
    assert_eq!(*harness.state().orbit(), before, "as at first");
    harness.key_press(Key::Num3);
    harness.run();
    harness.key_press(Key::D);
    harness.run();
    let edits = harness.state().edits();
    assert_eq!((edits.study, edits.taming), (Study::Ringing, Taming::Dering), "study and dering by keys");
}
