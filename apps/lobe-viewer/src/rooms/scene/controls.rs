//! The panel beside the picture.

use std::path::PathBuf;

use eframe::egui::{Button, Checkbox, ComboBox, ProgressBar, Slider, Ui};
use lobe::scene::built_in;

use crate::loading::mode::Mode;
use crate::loading::place::IN_PAGE;
use crate::loading::scene_source::built_in_source;
use crate::loading::sky_source;
use crate::loading::task::Task;
use crate::rooms::background;
use crate::rooms::light::suns_control;
use crate::rooms::scene::edits::{Comparison, PATHS_LOG2, SceneEdits};
use lobe::render::Surfaces;

/// Orders that the window bakes to.
const ORDERS: std::ops::RangeInclusive<usize> = 1..=8;

/// What a user asks for beside changes of the edits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Asked {
    /// A file, from the list of files.
    OpenFile,
    /// Transfer of the scene.
    Bake,
    /// An end of the work that is under way.
    Cancel,
    /// The whole scene in the picture.
    Frame,
}

/// The order and the paths of the next bake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BakePlan {
    pub(crate) order: usize,
    pub(crate) samples: u32,
}

/// What is known of the transfer that is there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    /// The order of transfer; none if there is none for the mode.
    pub(crate) order: Option<usize>,
    pub(crate) samples: Option<u32>,
    pub(crate) has_scene: bool,
}

pub(crate) fn scene_and_sky(ui: &mut Ui, edits: &mut SceneEdits) -> Option<Asked> {
    let mut asked = None;
    let name_of = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let scene = edits.scene.to_string_lossy().trim_start_matches("built-in:").to_owned();
    let shown = if edits.scene.to_string_lossy().starts_with("built-in:") { scene } else { name_of(&edits.scene) };
    ComboBox::from_label("Scene").selected_text(shown).show_ui(ui, |ui| {
        for name in built_in::NAMES.into_iter().filter(|name| *name != "furnace") {
            ui.selectable_value(&mut edits.scene, built_in_source(name), name);
        }
    });
    let title = sky_source::BUILT_IN.iter().find(|(name, _)| edits.sky == PathBuf::from(name));
    let shown = title.map_or_else(|| name_of(&edits.sky), |(_, title)| (*title).to_owned());
    ComboBox::from_label("Sky").selected_text(shown).show_ui(ui, |ui| {
        for (name, title) in sky_source::BUILT_IN {
            ui.selectable_value(&mut edits.sky, PathBuf::from(name), title);
        }
    });
    ui.horizontal(|ui| {
        if ui
            .button("Open a file")
            .on_hover_text("A scene or an environment; or drop it on the window (Ctrl+O)")
            .clicked()
        {
            asked = Some(Asked::OpenFile);
        }
        if ui.button("Frame").on_hover_text("The whole scene in the picture (F)").clicked() {
            asked = Some(Asked::Frame);
        }
    });
    asked
}

pub(crate) fn modes(ui: &mut Ui, edits: &mut SceneEdits, known: &Known) {
    for (number, mode) in Mode::ALL.into_iter().enumerate() {
        let hint = format!("{} ({})", mode.explain(), number + 1);
        ui.radio_value(&mut edits.mode, mode, mode.title()).on_hover_text(hint);
    }
    edits.light().expansion_controls(ui);
    match (edits.mode, known.order) {
        (Mode::Irradiance, _) => {}
        (_, Some(order)) if order < edits.order => {
            ui.weak(format!(
                "Transfer has order {order}: higher bands of the light are cut off. Bake it to a higher order."
            ));
        }
        (_, Some(_)) => {}
        (_, None) if known.has_scene => {
            ui.weak("Not baked yet: the picture is without shadows.");
        }
        (_, None) => {}
    }
    if edits.mode == Mode::Interreflected && !edits.has_materials() {
        // Matrices take storage buffers, and bakes that a page does not make.
        ui.add_enabled(!IN_PAGE, Checkbox::new(&mut edits.has_gloss, "Metals shine"))
            .on_hover_text("By transfer matrices; else they are matte");
    }
}

/// What is shown: the picture, or the truth by rays. `known` says what is known of that.
pub(crate) fn comparison(ui: &mut Ui, edits: &mut SceneEdits, known: &str) {
    for comparison in Comparison::ALL {
        ui.radio_value(&mut edits.comparison, comparison, comparison.title())
            .on_hover_text("Paths are traced while nothing moves, under the sky itself and not its expansion (R)");
    }
    if edits.comparison != Comparison::Off {
        ui.label(known);
    }
    if edits.comparison == Comparison::Difference {
        ui.weak("Red where the picture is too bright, blue where it is too dark.");
    }
}

pub(crate) fn sky_and_exposure(ui: &mut Ui, edits: &mut SceneEdits, is_turning: &mut bool) {
    edits.light().sky_controls(ui);
    ui.checkbox(is_turning, "Keep turning (T)");
    suns_control(ui, &mut edits.has_suns);
    materials_control(ui, &mut edits.surfaces);
    ui.add(Slider::new(&mut edits.sky_strength, 0.0..=8.0).text("Strength of the sky").fixed_decimals(2));
    background::control(ui, &mut edits.background);
}

/// Whether metals and plastics shine.
fn materials_control(ui: &mut Ui, surfaces: &mut Surfaces) {
    let mut is_on = *surfaces == Surfaces::MetallicRoughness;
    let hint = "Metals and plastics reflect the sky by their roughness, where shadows are shown; else all is matte";
    if ui.checkbox(&mut is_on, "Materials").on_hover_text(hint).changed() {
        *surfaces = if is_on { Surfaces::MetallicRoughness } else { Surfaces::Matte };
    }
}

pub(crate) fn bake<T>(ui: &mut Ui, plan: &mut BakePlan, known: &Known, task: Option<&Task<T>>) -> Option<Asked> {
    if let Some(order) = known.order {
        let paths = known.samples.map_or_else(String::new, |samples| format!(", {samples} paths"));
        ui.label(format!("Baked: order {order}{paths}"));
    }
    if let Some(task) = task {
        ui.label(task.describe());
        match task.progress() {
            Some(part) => ui.add(ProgressBar::new(part).show_percentage()),
            None => ui.spinner(),
        };
        return ui
            .button("Cancel")
            .on_hover_text("Stop; what is there already remains (Esc)")
            .clicked()
            .then_some(Asked::Cancel);
    }
    ui.add(Slider::new(&mut plan.order, ORDERS).text("Order of the bake"));
    let mut power = plan.samples.max(1).ilog2();
    let slider =
        Slider::new(&mut power, PATHS_LOG2).text("Paths").custom_formatter(|n, _| format!("{}", 1_u32 << n as u32));
    if ui.add(slider).changed() {
        plan.samples = 1 << power;
    }
    ui.add_enabled(known.has_scene, Button::new("Bake")).clicked().then_some(Asked::Bake)
}
