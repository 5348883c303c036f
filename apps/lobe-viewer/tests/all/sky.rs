//! The room of skies.

use eframe::egui::{Event, Key, Modifiers, PointerButton, Pos2, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use lobe::env::{Mapping, SunOptions, extract_sun, project_map};
use lobe::sh::encoding::{IrradianceEncoding, encoding_error};
use lobe::sh::expansion::Quantity;
use lobe::sh::extrema::certified_minimum;
use lobe::sh::light_extraction::{LightFitOptions, extract_lights};
use lobe::sh::sh_json::{ShFile, write_sh_json};
use lobe::sh::sphere::even_directions;
use lobe::sh::{Dir, Expansion as _, Rgb, Rotation, ShVec, Zonal};
use lobe_viewer::{OpenedSky, ReadLimits, Shelf, SkyEdits, SkyRoom, Step, Taming, open_sky};

use crate::wait::step_until;

pub(crate) struct Shown {
    pub(crate) room: SkyRoom,
    sky: Option<OpenedSky>,
}

pub(crate) fn open(edits: SkyEdits, sky: Option<OpenedSky>) -> Harness<'static, Shown> {
    open_in([1200.0, 1500.0], edits, sky)
}

/// The room in a window of this size: the narrower, the fewer pixels the sky has.
pub(crate) fn open_in(size: [f32; 2], edits: SkyEdits, sky: Option<OpenedSky>) -> Harness<'static, Shown> {
    let state = Shown { room: SkyRoom::new(edits), sky };
    let show = |ui: &mut eframe::egui::Ui, shown: &mut Shown| shown.room.ui(ui, shown.sky.as_ref());
    let mut harness = Harness::builder().with_size(size).build_ui_state(show, state);
    harness.run_steps(4);
    harness
}

#[test]
fn minimum_and_lights_on_the_screen_are_those_of_the_library() {
    let sky = open_sky("bundled:sunset".as_ref(), &ReadLimits::default()).unwrap();
    let mut harness = open(SkyEdits::default(), Some(sky.clone()));
    for key in [None, Some(Key::ArrowLeft)] {
        if let Some(key) = key {
            harness.get_all_by_label("Order").next().unwrap().focus();
            harness.run_steps(4);
            harness.key_press(key);
            harness.run_steps(4);
        }
        let edits = harness.state().room.edits().clone();
        let light = project_map(&sky.map, 8).resized(edits.order);
        let least = certified_minimum(light.map(Rgb::luminance).coefficients(), 1e-6);
        let text = format!("Minimum of the luminance: {:.4} (blue cross)", least.lo);
        assert!(harness.query_by_label(&text).is_some(), "order {}: {text}", edits.order);
        let fit = extract_lights(&light, &LightFitOptions::default().count(edits.lights)).unwrap();
        let [r, g, b] = <[f64; 3]>::from(fit.ambient);
        let text = format!("Ambient: {r:.2} {g:.2} {b:.2}");
        assert!(harness.query_by_label(&text).is_some(), "order {}: {text}", edits.order);
    }
    assert_eq!(harness.state().room.edits().order, SkyEdits::default().order - 1, "the key moved the slider");
}

#[test]
fn dering_leaves_no_channel_negative_and_the_room_says_so() {
    let sky = open_sky("made:evening".as_ref(), &ReadLimits::default()).unwrap();
    let mut edits = SkyEdits::default();
    edits.taming = Taming::Dering;
    let harness = open(edits, Some(sky.clone()));
    let light = Taming::Dering.tamed(&project_map(&sky.map, 8).resized(4));
    let least = certified_minimum(light.map(Rgb::luminance).coefficients(), 1e-6);
    assert!(least.hi > -1e-5, "{least:?}");
    let text = format!("Minimum of the luminance: {:.4} (blue cross)", least.lo);
    assert!(harness.query_by_label(&text).is_some(), "{text}");
}

#[test]
fn without_a_sky_the_room_waits() {
    let harness = open(SkyEdits::default(), None);
    assert!(harness.query_by_label("Opening the sky").is_some(), "it says what it waits for");
}

#[test]
fn skies_by_formula_are_light_everywhere_above_and_unknown_names_are_told() {
    for name in ["made:evening", "made:noon", "made:even"] {
        let sky = open_sky(name.as_ref(), &ReadLimits::default()).unwrap();
        let texels = sky.map.texels();
        assert!(texels.iter().all(|t| t.r >= 0.0 && t.g >= 0.0 && t.b >= 0.0), "{name}: no light is negative");
        assert!(sky.map.mean().luminance() > 0.01, "{name}: {:?}", sky.map.mean());
    }
    let line = open_sky("made:midnight".as_ref(), &ReadLimits::default()).unwrap_err().to_string();
    assert!(line.contains("made:evening") && !line.contains('\n'), "{line}");
    assert!(open_sky("no-such-file.exr".as_ref(), &ReadLimits::default()).is_err(), "no file");
}

#[test]
fn an_expansion_of_radiance_is_a_sky_and_comes_back_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("light.SH.json");
    let color = |i: usize| Rgb::new((i as f64).cos(), 0.5 * (i as f64).sin(), if i == 0 { 3.0 } else { -0.1 });
    let light = ShVec::from_vec((0..16).map(color).collect()).unwrap();
    write_sh_json(&path, &ShFile::new(Quantity::Radiance, light.clone())).unwrap();
    let sky = open_sky(&path, &ReadLimits::default()).unwrap();
    let back = project_map(&sky.map, 4);
    for (i, (a, b)) in back.coefficients().iter().zip(light.coefficients()).enumerate() {
        let apart = (*a - *b).to_array().into_iter().fold(0.0, |most: f64, c| most.max(c.abs()));
        // 12 Δ²/24 of band 3, with Δ = π/512.
        assert!(apart < 5e-5, "coefficient {i}: {a:?}, written {b:?}");
    }
    write_sh_json(&path, &ShFile::new(Quantity::Irradiance, light)).unwrap();
    let line = open_sky(&path, &ReadLimits::default()).unwrap_err().to_string();
    assert!(line.contains("light.SH.json: expected the radiance of surroundings, found irradiance"), "{line}");
}

/// Types into a cell of the table and leaves it.
fn type_into(harness: &mut Harness<'_, Shown>, cell: &str, text: &str) {
    harness.get_by_label(cell).focus();
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.get_by_label(cell).type_text(text);
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
}

/// The line of the minimum for an expansion.
pub(crate) fn minimum_of(light: &ShVec<Rgb<f64>>) -> String {
    let least = certified_minimum(light.map(Rgb::luminance).coefficients(), 1e-6);
    format!("Minimum of the luminance: {:.4} (blue cross)", least.lo)
}

#[test]
fn a_coefficient_that_is_typed_changes_the_expansion_and_is_undone() {
    let sky = open_sky("bundled:sunset".as_ref(), &ReadLimits::default()).unwrap();
    let mut harness = open(SkyEdits::default(), Some(sky.clone()));
    harness.run_steps(20);
    let before = project_map(&sky.map, 8).resized(4);
    assert!(harness.query_by_label(&minimum_of(&before)).is_some(), "the sky's own");
    type_into(&mut harness, "Band 1, 0, red", "-2.5");
    let mut changed = before.clone();
    changed.coefficients_mut()[2].r = -2.5;
    assert_ne!(minimum_of(&changed), minimum_of(&before), "it shows");
    assert!(harness.query_by_label(&minimum_of(&changed)).is_some(), "{}", minimum_of(&changed));
    // Undo knows a change once it has rested for a second.
    harness.run_steps(200);
    harness.state_mut().room.step(Step::Undo);
    harness.run_steps(2);
    assert!(harness.query_by_label(&minimum_of(&before)).is_some(), "undone");
    harness.state_mut().room.step(Step::Redo);
    harness.run_steps(2);
    assert!(harness.query_by_label(&minimum_of(&changed)).is_some(), "made again");
    harness.get_by_label("Those of the sky again").click();
    harness.run_steps(2);
    assert!(harness.query_by_label(&minimum_of(&before)).is_some(), "all of them back");
}

#[test]
fn a_coefficient_that_is_typed_under_a_turned_sky_is_shown_as_it_was_typed() {
    let sky = open_sky("bundled:sunset".as_ref(), &ReadLimits::default()).unwrap();
    let mut edits = SkyEdits::default();
    (edits.turn, edits.tilt, edits.has_expansion) = (0.7, -0.4, true);
    let mut harness = open(edits, Some(sky));
    harness.run_steps(20);
    let cell = |harness: &Harness<'_, Shown>, name: &str| harness.get_by_label(name).accesskit_node().value().unwrap();
    let others = ["Band 0, 0, red", "Band 1, -1, red", "Band 1, 1, red", "Band 1, 0, blue"];
    let before = others.map(|name| cell(&harness, name));
    type_into(&mut harness, "Band 1, 0, red", "-2.5");
    assert_eq!(cell(&harness, "Band 1, 0, red"), "-2.5000", "the number that was typed");
    assert_eq!(others.map(|name| cell(&harness, name)), before, "and no other changes");
    assert_eq!(harness.state().room.edits().own.len(), 3, "in the frame of the sky its band is another");
    harness.get_by_label("Those of the sky again").click();
    harness.run_steps(2);
    assert_ne!(cell(&harness, "Band 1, 0, red"), "-2.5000", "back to that of the sky");
}

#[test]
fn what_is_no_number_is_refused_in_words_and_changes_nothing() {
    let sky = open_sky("made:evening".as_ref(), &ReadLimits::default()).unwrap();
    let mut harness = open(SkyEdits::default(), Some(sky));
    for text in ["NaN", "inf", "red", " ", "1e300", "1,5"] {
        type_into(&mut harness, "Band 1, -1, blue", text);
        let said = format!("Band 1, -1, blue: expected a number from -1000000 to 1000000, found '{}'", text.trim());
        assert!(harness.query_by_label_contains(&said).is_some(), "{said}");
        assert!(harness.state().room.edits().own.is_empty(), "{text}: nothing changed");
    }
    type_into(&mut harness, "Band 1, -1, blue", "1.5");
    assert!(harness.query_by_label_contains("expected a number").is_none(), "a number ends the complaint");
    assert_eq!(harness.state().room.edits().own[0].value[2], 1.5, "and is taken");
}

#[test]
#[ignore = "long: of the nightly group"]
fn coefficients_change_every_second_and_come_around() {
    let sky = open_sky("bundled:sunset".as_ref(), &ReadLimits::default()).unwrap();
    let mut harness = open_in([600.0, 1500.0], SkyEdits::default(), Some(sky.clone()));
    harness.get_by_label("Change every second").click();
    harness.run_steps(1);
    let light = project_map(&sky.map, 8).resized(4);
    let dt = 0.25;
    let steps = |seconds: f64| (seconds / dt) as usize;
    let cell =
        |harness: &Harness<'_, Shown>| harness.get_by_label("Band 1, 1, green").accesskit_node().value().unwrap();
    let mut seen = vec![cell(&harness)];
    for _ in 0..24 {
        harness.run_steps(steps(1.0));
        seen.push(cell(&harness));
    }
    let expected = |step: usize| {
        let turn = Rotation::from_axis_angle(Dir::Z, std::f64::consts::TAU * step as f64 / 24.0);
        format!("{:.4}", light.rotated(&turn).coefficients()[3].g)
    };
    let first = (0..24).find(|k| expected(*k) == seen[0]).unwrap();
    for (passed, found) in seen.iter().enumerate() {
        assert_eq!(*found, expected((first + passed) % 24), "after {passed} seconds");
    }
}

#[test]
fn what_was_typed_belongs_to_its_sky() {
    let sky = open_sky("made:even".as_ref(), &ReadLimits::default()).unwrap();
    let mut edits = SkyEdits::default();
    edits.replace(2, Rgb::new(1.0, 2.0, 3.0));
    edits.replace(2, Rgb::new(4.0, 5.0, 6.0));
    assert_eq!(edits.own.len(), 1, "one value for a coefficient");
    let mut harness = open(edits, Some(sky));
    assert_eq!(harness.state().room.edits().own[0].value, [4.0, 5.0, 6.0], "kept for the first sky that is opened");
    harness.state_mut().sky = Some(open_sky("made:noon".as_ref(), &ReadLimits::default()).unwrap());
    harness.run_steps(2);
    assert!(harness.state().room.edits().own.is_empty(), "another sky has coefficients of its own");
}

/// Presses and releases the mouse at a place.
fn click_at(harness: &mut Harness<'_, Shown>, at: Pos2) {
    harness.event(Event::PointerMoved(at));
    harness.run_steps(2);
    for pressed in [true, false] {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        harness.event(Event::PointerButton { pos: at, button, pressed, modifiers });
        harness.run_steps(1);
    }
    harness.run_steps(2);
}

/// Where a direction is in the lat-long picture of the sky.
fn place_in_sky(harness: &Harness<'_, Shown>, s: Dir) -> Pos2 {
    let rect = harness.get_by_label("The sky, lat-long").rect();
    let (u, v) = Mapping::LatLong.uv_from_dir(s);
    pos2(rect.left() + u as f32 * rect.width(), rect.top() + v as f32 * rect.height())
}

#[test]
fn a_sun_is_taken_out_by_a_click_on_it_and_what_is_left_is_that_of_the_library() {
    let sky = open_sky("bundled:sunset".as_ref(), &ReadLimits::default()).unwrap();
    let report = extract_sun(&sky.map, &SunOptions::default()).unwrap();
    let mut harness = open(SkyEdits::default(), Some(sky.clone()));
    step_until(&mut harness, |shown| shown.room.has_looked_for_suns());
    let away = place_in_sky(&harness, -report.sun.direction);
    click_at(&mut harness, away);
    assert!(harness.query_by_label_contains("No sun at azimuth").is_some(), "it says that there is none");
    let at = place_in_sky(&harness, report.sun.direction);
    click_at(&mut harness, at);
    step_until(&mut harness, |shown| !shown.room.suns().is_empty());
    harness.run_steps(3);
    assert_eq!(harness.state().room.suns(), [report.sun], "the sun of the library");
    let [r, g, b] = <[f64; 3]>::from(report.sun.irradiance);
    let text = format!("Irradiance {r:.3} {g:.3} {b:.3}, from {} texels", report.sun.texels);
    assert!(harness.query_by_label(&text).is_some(), "{text}");
    let rest = project_map(&report.rest, 8).resized(4);
    assert!(harness.query_by_label(&minimum_of(&rest)).is_some(), "{}", minimum_of(&rest));
    harness.get_by_label("Put the suns back").click();
    harness.run_steps(2);
    step_until(&mut harness, |shown| shown.room.suns().is_empty());
    harness.run_steps(3);
    let whole = minimum_of(&project_map(&sky.map, 8).resized(4));
    assert!(harness.query_by_label(&whole).is_some(), "{whole}");
}

#[test]
#[ignore = "long: of the nightly group"]
fn the_errors_of_encodings_are_those_of_the_library() {
    let sky = open_sky("bundled:sunset".as_ref(), &ReadLimits::default()).unwrap();
    let mut harness = open(SkyEdits::default(), Some(sky.clone()));
    harness.get_by_label("Encodings of irradiance").click();
    harness.run_steps(40);
    let irradiance = sky.light.convolved(&Zonal::clamped_cosine(8));
    let truth: Vec<_> = even_directions(256).map(|n| (n, irradiance.eval(n))).collect();
    for encoding in IrradianceEncoding::ALL {
        let error = encoding_error(encoding, &irradiance, &truth).rms;
        let text = format!("{}: {} numbers, {:.1} %", encoding.name(), encoding.floats(3), 100.0 * error);
        assert!(harness.query_by_label(&text).is_some(), "{text}");
    }
}

#[test]
#[ignore = "long: of the nightly group"]
fn every_technique_has_a_ball_and_a_distance_from_the_first_of_its_row() {
    let mut edits = SkyEdits::default();
    edits.shelf = Shelf::Techniques;
    let mut harness = open(edits, Some(open_sky("made:noon".as_ref(), &ReadLimits::default()).unwrap()));
    let names = [
        "Mirrors, the map itself",
        "Mirrors, lat-long map",
        "Mirrors, sphere map",
        "Mirrors, cube map",
        "Mirrors, dual paraboloid",
        "Mirrors, by the expansion",
        "Mirrors with bumps, the map itself",
        "Mirrors with bumps, cube map",
        "Mirrors with bumps, by the expansion",
        "Mirrors in the shape of a ring, truth: traced",
        "Mirrors in the shape of a ring, the map itself",
        "Mirrors in the shape of a ring, cube map",
        "Mirrors in the shape of a ring, by the expansion",
        "Glossy: GGX of α = 0.3, truth: a sum over lights",
        "Glossy: GGX of α = 0.3, split sum",
        "Glossy: GGX of α = 0.3, maps of 12 views",
        "Glossy: GGX of α = 0.3, by the expansion",
        "Matte with highlights: Phong of s = 30, truth: a sum over lights",
        "Matte with highlights: Phong of s = 30, highlight map",
        "Matte with highlights: Phong of s = 30, by the expansion",
        "Matte, truth: a sum over lights",
        "Matte, irradiance map",
        "Matte, nine coefficients",
        "Matte, by the expansion",
    ];
    while !names.iter().all(|name| harness.query_by_label(name).is_some()) {
        harness.run_steps(2);
    }
    let percents = harness.get_all_by_label_contains(" %").count();
    assert!(percents >= names.len() - 6, "all but the six truths have an error: {percents}");
}

#[test]
fn keys_turn_the_camera_the_sky_and_its_expansion() {
    let sky = open_sky("bundled:sunset".as_ref(), &ReadLimits::default()).unwrap();
    let mut harness = open(SkyEdits::default(), Some(sky.clone()));
    let before = *harness.state().room.orbit();
    harness.key_press(Key::ArrowLeft);
    harness.key_press(Key::Minus);
    harness.run_steps(2);
    let orbit = harness.state().room.orbit();
    assert!(orbit.azimuth != before.azimuth && orbit.distance > before.distance, "turned and farther: {orbit:?}");
    harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowRight);
    harness.key_press(Key::Comma);
    harness.run_steps(3);
    let edits = harness.state().room.edits().clone();
    assert_eq!((edits.order, edits.turn.to_degrees().round()), (3, 5.0), "the sky and the order");
    // The minimum is that of the turned expansion, elsewhere and of the same value.
    let turned = project_map(&sky.map, 8).resized(3).rotated(&edits.rotation());
    let cell = harness.get_by_label("Band 1, 1, green").accesskit_node().value().unwrap();
    assert_eq!(cell, format!("{:.4}", turned.coefficients()[3].g), "the coefficients are those of the turned sky");
}
