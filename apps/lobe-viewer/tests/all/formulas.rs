//! Formulas in the rooms: they show at a press, and are those of what was chosen.

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lobe_viewer::{
    Formula, FunctionsEdits, FunctionsRoom, MotionEdits, MotionRoom, SceneEdits, SceneRoom, Section, Shelf, SkyEdits,
    SkyRoom, Study, Taming, UserFolder, open_sky,
};

use crate::press::choose;

/// Whether a formula is on the screen.
fn has<S>(harness: &Harness<'_, S>, formula: Formula) -> bool {
    harness.query_by_label(formula.text).is_some()
}

/// Those of all formulas that are on the screen.
fn on_screen<S>(harness: &Harness<'_, S>) -> Vec<Formula> {
    Formula::ALL.into_iter().filter(|formula| has(harness, *formula)).collect()
}

fn unfold<S>(harness: &mut Harness<'_, S>) {
    harness.get_by_label("Formulas").click();
    harness.run_steps(8);
}

#[test]
fn formulas_are_folded_at_first_and_have_the_sources_of_the_list_and_chapters_of_the_guide() {
    let mut harness = functions(Study::Rotate);
    assert!(on_screen(&harness).is_empty(), "folded");
    unfold(&mut harness);
    assert_eq!(on_screen(&harness), [Formula::PROJECTION, Formula::ROTATION], "unfolded");
    assert!(harness.query_by_label("[Green 2003], guide: Expansions").is_some(), "with its source");
    unfold(&mut harness);
    assert!(on_screen(&harness).is_empty(), "folded again");
    let (references, chapters) =
        (include_str!("../../../../REFERENCES.bib"), include_str!("../../../../docs/guide/src/SUMMARY.md"));
    for Formula { title, text, source, chapter, .. } in Formula::ALL {
        assert!(text.lines().all(|line| line.chars().count() <= 34), "{title}: lines fit beside a picture");
        assert!(chapters.contains(&format!("[{chapter}]")), "{title}: there is no chapter {chapter}");
        let year = source.trim_matches(['[', ']']).rsplit(' ').next().unwrap();
        let first = source.trim_start_matches('[').split([' ', ',']).next().unwrap();
        let is_listed = references.lines().any(|line| {
            line.starts_with('@') && line.contains(&format!("{{{first}")) && line.ends_with(&format!("{year},"))
        });
        assert!(source.is_empty() || is_listed, "{title}: {source} is not in the list");
    }
}

fn functions(study: Study) -> Harness<'static, FunctionsRoom> {
    let mut edits = FunctionsEdits::default();
    // Few pictures, of few bands.
    (edits.study, edits.order, edits.has_crosses, edits.section) = (study, 2, false, Section::None);
    let room = FunctionsRoom::new(edits);
    let mut harness =
        Harness::builder().with_size([700.0, 1500.0]).build_ui_state(|ui, room: &mut FunctionsRoom| room.ui(ui), room);
    harness.run_steps(2);
    harness
}

#[test]
fn each_study_has_its_formula_and_each_window_its_own() {
    let mut harness = functions(Study::Product);
    unfold(&mut harness);
    assert_eq!(on_screen(&harness), [Formula::PRODUCT], "of products");
    harness.get_by_label(Study::AmbientCube.title()).click();
    harness.run_steps(2);
    assert_eq!(on_screen(&harness), [Formula::IRRADIANCE, Formula::AMBIENT_CUBE], "of the cube");
    harness.get_by_label(Study::Ringing.title()).click();
    harness.run_steps(2);
    assert_eq!(on_screen(&harness), [Formula::CONE], "of a light");
    for (name, formula) in [
        ("Hanning", Formula::HANNING),
        ("Lanczos", Formula::LANCZOS),
        ("Sinc4", Formula::SINC4),
        ("Gauss", Formula::GAUSS),
        ("Squared Laplacian", Formula::LAPLACIAN),
        ("Punctual lights", Formula::PUNCTUAL),
        ("Dering by radiance", Formula::DERING),
        ("Dering by irradiance", Formula::DERING_IRRADIANCE),
    ] {
        choose(&mut harness, "Window", name);
        let found: Vec<Formula> = on_screen(&harness).into_iter().filter(|found| *found != Formula::CONE).collect();
        assert_eq!(found, [formula], "of what was chosen");
    }
}

#[test]
fn the_room_of_skies_has_the_formulas_of_its_balls() {
    let sky = open_sky("made:even".as_ref(), &Default::default()).unwrap();
    let room = SkyRoom::new(sky_edits());
    let show = move |ui: &mut eframe::egui::Ui, room: &mut SkyRoom| room.ui(ui, Some(&sky));
    let mut harness = Harness::builder().with_size([500.0, 1500.0]).build_ui_state(show, room);
    harness.run_steps(3);
    unfold(&mut harness);
    assert_eq!(on_screen(&harness), [Formula::PROJECTION, Formula::HANNING], "of the expansion");
    harness.get_by_label(Shelf::Encodings.title()).click();
    harness.run_steps(2);
    for formula in [Formula::IRRADIANCE, Formula::ZH3, Formula::AMBIENT_CUBE, Formula::H_BASIS] {
        assert!(has(&harness, formula), "{}", formula.title);
    }
    harness.state_mut().edits_mut().shelf = Shelf::Techniques;
    harness.state_mut().edits_mut().lights = 1;
    harness.run_steps(2);
    let techniques = [Formula::MIRROR, Formula::BUMPS, Formula::SPLIT_SUM, Formula::HIGHLIGHTS, Formula::IRRADIANCE];
    for formula in techniques.into_iter().chain([Formula::LIGHTS]) {
        assert!(has(&harness, formula), "{}", formula.title);
    }
    assert!(!has(&harness, Formula::ZH3), "no longer that of an encoding");
}

fn sky_edits() -> SkyEdits {
    let mut edits = SkyEdits::default();
    (edits.lights, edits.taming, edits.order, edits.has_expansion) = (0, Taming::Hanning(3.0), 1, true);
    edits
}

#[test]
fn each_light_path_has_its_transfer_and_the_truth_its_integral() {
    let mut edits = SceneEdits::default();
    (edits.scene, edits.sky, edits.order) = ("built-in:furnace".into(), "made:even".into(), 1);
    let room = SceneRoom::new(edits, None, UserFolder::none());
    // Nothing is opened: what is computed is known before.
    let show = |ui: &mut eframe::egui::Ui, room: &mut SceneRoom| room.ui(ui, None);
    let mut harness = Harness::builder().with_size([1000.0, 1500.0]).build_ui_state(show, room);
    harness.run_steps(2);
    unfold(&mut harness);
    let metals = [Formula::ROTATION, Formula::TRANSFER, Formula::INTERREFLECTED, Formula::GLOSSY];
    assert_eq!(on_screen(&harness), metals, "with metals that shine");
    for (name, formulas) in [
        ("Metals shine", &[Formula::ROTATION, Formula::TRANSFER, Formula::INTERREFLECTED][..]),
        ("Irradiance", &[Formula::ROTATION, Formula::UNSHADOWED]),
        ("Shadowed", &[Formula::ROTATION, Formula::TRANSFER, Formula::SHADOWED]),
        ("Difference", &[Formula::ROTATION, Formula::TRANSFER, Formula::BOUNCES]),
        (
            "Difference to the truth",
            &[Formula::ROTATION, Formula::TRANSFER, Formula::BOUNCES, Formula::TRUTH, Formula::RMS],
        ),
    ] {
        harness.get_by_label(name).click();
        harness.run_steps(2);
        assert_eq!(on_screen(&harness), formulas, "{name}");
    }
}

#[test]
fn each_way_of_shadows_has_its_formula() {
    let folder = tempfile::tempdir().unwrap();
    let mut room = MotionRoom::new(MotionEdits::default());
    room.open(&crate::motion::described(folder.path()));
    let show = |ui: &mut eframe::egui::Ui, room: &mut MotionRoom| room.ui(ui, None, None);
    let mut harness = Harness::builder().with_size([1000.0, 1500.0]).build_ui_state(show, room);
    harness.run_steps(2);
    unfold(&mut harness);
    let common = [Formula::PRODUCT, Formula::MOVING];
    assert_eq!(on_screen(&harness), [&common[..], &[Formula::FIELDS]].concat(), "by fields");
    harness.get_by_label("Spheres, SH exponentials").click();
    harness.run_steps(2);
    assert_eq!(on_screen(&harness), [&common[..], &[Formula::EXPONENTIALS]].concat(), "by exponentials");
    harness.get_by_label("Truth by rays").click();
    harness.run_steps(2);
    assert_eq!(on_screen(&harness), [Formula::TRUTH, Formula::RMS], "by paths");
}
