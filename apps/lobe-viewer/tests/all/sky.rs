//! The room of skies.

use eframe::egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lobe::env::project_map;
use lobe::sh::{Expansion as _, LightFitOptions, Rgb, certified_minimum, extract_lights};
use lobe_viewer::{OpenedSky, SkyEdits, SkyRoom, Taming, open_sky};

struct Shown {
    room: SkyRoom,
    sky: Option<OpenedSky>,
}

fn open(edits: SkyEdits, sky: Option<OpenedSky>) -> Harness<'static, Shown> {
    let state = Shown { room: SkyRoom::new(edits), sky };
    let show = |ui: &mut eframe::egui::Ui, shown: &mut Shown| shown.room.ui(ui, shown.sky.as_ref());
    let mut harness = Harness::builder().with_size([1200.0, 1500.0]).build_ui_state(show, state);
    harness.run();
    harness
}

#[test]
fn minimum_and_lights_on_the_screen_are_those_of_the_library() {
    let sky = open_sky("bundled:sunset".as_ref()).unwrap();
    let mut harness = open(SkyEdits::default(), Some(sky.clone()));
    for key in [None, Some(Key::ArrowLeft)] {
        if let Some(key) = key {
            harness.get_all_by_label("Order").next().unwrap().focus();
            harness.run();
            harness.key_press(key);
            harness.run();
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
    let sky = open_sky("made:evening".as_ref()).unwrap();
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
        let sky = open_sky(name.as_ref()).unwrap();
        let texels = sky.map.texels();
        assert!(texels.iter().all(|t| t.r >= 0.0 && t.g >= 0.0 && t.b >= 0.0), "{name}: no light is negative");
        assert!(sky.map.mean().luminance() > 0.01, "{name}: {:?}", sky.map.mean());
    }
    let line = open_sky("made:midnight".as_ref()).unwrap_err().to_string();
    assert!(line.contains("made:evening") && !line.contains('\n'), "{line}");
    assert!(open_sky("no-such-file.exr".as_ref()).is_err(), "no file");
}
