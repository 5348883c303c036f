//! The room of functions: what is pressed, and what is shown.

use eframe::egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lobe::sh::encoding::AmbientCube;
use lobe::sh::expansion::Quantity;
use lobe::sh::extrema::certified_minimum;
use lobe::sh::sh_json::{ShFile, write_sh_json};
use lobe::sh::{Dir, Expansion as _, ShL2, ShVec, Window, Zonal};
use lobe_viewer::{FunctionsEdits, FunctionsRoom, Section, Shape, Study, Taming};

use crate::press::{choose, slide};

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
    let turned = edits.function().rotated(&edits.rotation());
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
    let (kept, all) = (f.product(&g, edits.order), f.product(&g, 2 * edits.order - 1));
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
    let tamed = Taming::Dering.tamed(&harness.state().edits().ringing_light());
    let least = certified_minimum(tamed.coefficients(), 1e-9);
    assert!(least.lo > -1e-6, "{least:?}");
    let at = least.dir.theta().to_degrees();
    let text = format!("Minimum, tamed: {:.5}, {at:.0}° from the axis", least.lo);
    assert!(harness.query_by_label(&text).is_some(), "{text}");
}

/// The line of a minimum.
fn minimum(name: &str, f: &ShVec<f64>) -> String {
    let found = certified_minimum(f.coefficients(), 1e-9);
    format!("{name}: {:.5}, {:.0}° from the axis", found.lo, found.dir.theta().to_degrees())
}

#[test]
fn factors_and_minima_on_the_screen_are_those_of_each_window_and_each_dering() {
    for taming in [Taming::Sinc4(6.0), Taming::Laplacian(0.01), Taming::Punctual, Taming::DeringIrradiance] {
        let harness = open(edits(|edits| {
            (edits.study, edits.taming, edits.has_crosses, edits.section) =
                (Study::Ringing, taming, false, Section::None);
        }));
        let light = harness.state().edits().ringing_light();
        let factors: Vec<String> = taming.factors(&light).iter().map(|w| format!("{w:.4}")).collect();
        let text = format!("Factors of the bands: {}", factors.join(" "));
        assert!(harness.query_by_label(&text).is_some(), "{}: {text}", taming.title());
        let tamed = taming.tamed(&light);
        let received = tamed.convolved(&Zonal::clamped_cosine(light.order()));
        for text in [minimum("Minimum, tamed", &tamed), minimum("Minimum of the irradiance, tamed", &received)] {
            assert!(harness.query_by_label(&text).is_some(), "{}: {text}", taming.title());
        }
    }
}

#[test]
fn dering_by_irradiance_leaves_radiance_below_zero_and_no_irradiance() {
    let light = edits(|edits| edits.study = Study::Ringing).ringing_light();
    let tamed = Taming::DeringIrradiance.tamed(&light);
    let received = tamed.convolved(&Zonal::clamped_cosine(light.order()));
    let [radiance, irradiance] = [&tamed, &received].map(|f| certified_minimum(f.coefficients(), 1e-9).lo);
    assert!(radiance < -1e-3 && irradiance > -1e-6, "least radiance {radiance}, least irradiance {irradiance}");
}

#[test]
fn the_peak_of_an_impulse_finds_the_width_of_a_window() {
    // Sloan 2008 compares windows of order 6 at this peak.
    for (taming, expected) in [
        (Taming::Hanning(6.0), Window::Hanning { width: 12.010498388175 }),
        (Taming::Lanczos { width: 6.0, power: 1.0 }, Window::Lanczos { width: 9.872527032259, power: 1.0 }),
        (Taming::Lanczos { width: 6.0, power: 2.0 }, Window::Lanczos { width: 13.712128048, power: 2.0 }),
    ] {
        let mut harness = open(edits(|edits| {
            (edits.study, edits.order, edits.taming) = (Study::Ringing, 6, taming);
            (edits.has_crosses, edits.section) = (false, Section::None);
        }));
        slide(&mut harness, "Peak of an impulse", 2.25);
        let found = harness.state().edits().taming.window().unwrap();
        for l in 0..6 {
            let [a, b] = [found, expected].map(|window| window.factor(l));
            assert!((a - b).abs() < 1e-8, "band {l}: {found} has {a}, {expected} has {b}");
        }
        harness.run_steps(4);
        assert_eq!(harness.state().edits().taming.window(), Some(found), "and it stays");
    }
}

#[test]
fn windows_follow_each_other_by_a_key_and_dering_goes_by_another() {
    let mut harness = open(edits(|edits| {
        (edits.study, edits.has_crosses, edits.section) = (Study::Ringing, false, Section::None);
    }));
    let mut titles = vec![harness.state().edits().taming.title()];
    for _ in 0..9 {
        harness.key_press(Key::W);
        harness.run();
        titles.push(harness.state().edits().taming.title());
    }
    let around = titles.iter().skip(1).position(|title| *title == titles[0]);
    assert_eq!(around, Some(8), "after the last none: {titles:?}");
    for (before, after) in [(Taming::DeringIrradiance, Taming::None), (Taming::Punctual, Taming::Dering)] {
        let mut harness = open(edits(|edits| {
            (edits.study, edits.taming, edits.has_crosses, edits.section) =
                (Study::Ringing, before, false, Section::None);
        }));
        harness.key_press(Key::D);
        harness.run();
        assert_eq!(harness.state().edits().taming, after, "after {}", before.title());
    }
}

#[test]
fn the_function_of_a_file_can_be_chosen_again_after_another() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("f.sh.json");
    let numbers = ShVec::from_vec((0..9).map(|i| 0.5 - 0.1 * f64::from(i)).collect()).unwrap();
    write_sh_json(&path, &ShFile::new(Quantity::Irradiance, numbers.clone())).unwrap();
    let mut harness = open(edits(|edits| (edits.has_crosses, edits.section) = (false, Section::None)));
    harness.state_mut().open(&path).unwrap();
    harness.run();
    choose(&mut harness, "f", "Impulse");
    assert_eq!(harness.state().edits().shape, Shape::Impulse, "another one");
    choose(&mut harness, "f", "From a file");
    let edits = harness.state().edits();
    assert_eq!(edits.shape, Shape::Opened, "that of the file again");
    for (found, expected) in edits.function().coefficients().iter().zip(numbers.coefficients()) {
        assert!((found - expected).abs() < 1e-12, "{found}, written {expected}");
    }
}

#[test]
fn keys_of_the_order_change_no_study_that_is_not_seen() {
    let mut harness = open(edits(|edits| {
        (edits.study, edits.has_crosses, edits.section) = (Study::AmbientCube, false, Section::None);
    }));
    harness.key_press(Key::Comma);
    harness.run();
    assert_eq!(harness.state().edits().order, FunctionsEdits::default().order, "the cube has no order");
    harness.key_press(Key::Num1);
    harness.run();
    harness.key_press(Key::Comma);
    harness.run();
    assert_eq!(harness.state().edits().order, FunctionsEdits::default().order - 1, "a rotation has");
}

#[test]
fn the_cube_wobbles_by_what_is_shown() {
    let mut harness = open(edits(|edits| edits.study = Study::AmbientCube));
    press(&mut harness, "Azimuth of the light", Key::ArrowRight);
    let edits = harness.state().edits();
    let light = Dir::from_angles(std::f64::consts::FRAC_PI_2, edits.light_at.to_radians());
    let irradiance = ShL2::impulse(light, 1.0).convolved(&Zonal::clamped_cosine(3));
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
    let turned = edits.function().rotated(&edits.rotation());
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
