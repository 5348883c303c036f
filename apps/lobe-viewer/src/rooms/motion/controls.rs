//! The panel beside the picture: how what moves is seen, its light, and where its parts are.

use std::path::{Path, PathBuf};

use eframe::egui::{ComboBox, ProgressBar, Slider, SliderClamping, Ui};
use lobe::motion::MovingMethod;
use lobe::scene::built_in;
use lobe::shadow::SphereFitMethod;

use crate::loading::moving_light::LitOn;
use crate::loading::moving_source::built_in_moving;
use crate::loading::scene_source::BUILT_IN;
use crate::loading::task::Task;
use crate::rooms::background;
use crate::rooms::light::{angle, suns_control};
use crate::rooms::motion::cast::Cast;
use crate::rooms::motion::edits::{MOST_SPHERES, MotionEdits, MotionView};
use crate::rooms::motion::panes::Panes;
use crate::rooms::motion::player::{Fit, MOST_ORDER, News};

/// Where moments can be lit.
const PLACES: [(LitOn, &str, &str); 3] = [
    (LitOn::Auto, "the faster", "The device, unless that is a program which emulates one"),
    (LitOn::Device, "the device", "Orders up to 6, without lamps; else the processor"),
    (LitOn::Processor, "the processor", "Everything"),
];

/// The choice of the scene; another one, where it was chosen.
pub(crate) fn scene(ui: &mut Ui, source: &Path) -> Option<PathBuf> {
    let mut chosen = source.to_path_buf();
    let name = source.file_name().unwrap_or_default().to_string_lossy();
    ComboBox::from_label("Scene").selected_text(name.trim_start_matches(BUILT_IN)).show_ui(ui, |ui| {
        for known in built_in::MOVING_NAMES {
            ui.selectable_value(&mut chosen, built_in_moving(known), known);
        }
    });
    (chosen != source).then_some(chosen)
}

/// How what moves is seen, and what is known of its truth.
pub(crate) fn view(ui: &mut Ui, edits: &mut MotionEdits, panes: &Panes) {
    for (number, view) in MotionView::ALL.into_iter().enumerate() {
        ui.radio_value(&mut edits.view, view, view.title()).on_hover_text(format!("{}", number + 1));
    }
    if edits.view.panes().contains(&MotionView::Truth) {
        ui.label(panes.describe());
    }
    for pane in edits.view.panes() {
        if let Some(error) = panes.error(*pane) {
            ui.label(format!("{}: {:.1} % from the truth", pane.title(), 100.0 * error));
        }
    }
    ui.checkbox(&mut edits.has_spheres, "Draw the spheres");
    ui.horizontal_wrapped(|ui| {
        ui.label("Lit on");
        for (place, title, hint) in PLACES {
            ui.radio_value(&mut edits.lit_on, place, title).on_hover_text(hint);
        }
    });
    let is_by_spheres = edits.methods().contains(&MovingMethod::Exponentials);
    ui.add_enabled_ui(is_by_spheres, |ui| spheres(ui, &mut edits.fit));
}

/// What is to become of bakes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wish {
    /// They end; the last moment that was lit remains.
    Cancel,
    /// The scene is opened and baked again.
    Bake,
}

/// How far the bakes are, and their end; or their begin, if they were stopped before anything was there.
pub(crate) fn progress(ui: &mut Ui, task: &Task<News>, is_stopped: bool) -> Option<Wish> {
    if task.is_at_work() {
        ui.label(task.describe());
        match task.progress() {
            Some(part) => ui.add(ProgressBar::new(part).show_percentage()),
            None => ui.spinner(),
        };
        let button = ui.button("Cancel").on_hover_text("Stop; what was lit last remains (Esc)");
        return button.clicked().then_some(Wish::Cancel);
    }
    let is_pressed = is_stopped && ui.button("Bake").on_hover_text("Open and bake the scene again").clicked();
    is_pressed.then_some(Wish::Bake)
}

/// The order of all that is baked, and the light.
pub(crate) fn light(ui: &mut Ui, edits: &mut MotionEdits, most_order: usize, is_turning: &mut bool) {
    let mut order = edits.order.min(most_order);
    let slider = Slider::new(&mut order, 1..=most_order).text("Order");
    // Each order is a bake of its own: while the handle is held, none is asked for.
    let hint = "Number of bands of the light and of all that is baked (comma, point)";
    if ui.add(slider.update_while_editing(false)).on_hover_text(hint).changed() {
        edits.order = order;
    }
    if most_order < MOST_ORDER {
        ui.weak(format!("Parts came baked to order {most_order}."));
    }
    edits.taming.controls(ui, order);
    edits.light(most_order).sky_controls(ui);
    ui.checkbox(is_turning, "Keep turning (T)");
    suns_control(ui, &mut edits.has_suns);
    background::control(ui, &mut edits.background);
}

/// Whether a user moves the parts, and where to.
pub(crate) fn by_hand(ui: &mut Ui, edits: &mut MotionEdits, chosen: &mut usize, cast: &Cast) {
    ui.add_enabled_ui(cast.is_rigid, |ui| {
        let response = ui.checkbox(&mut edits.is_by_hand, "Move objects by hand");
        response.on_disabled_hover_text("What changes its shape is moved by its animation only");
    });
    if edits.is_by_hand {
        hands(ui, edits, chosen, cast);
    }
}

/// Where a user puts the parts.
fn hands(ui: &mut Ui, edits: &mut MotionEdits, chosen: &mut usize, cast: &Cast) {
    let name = cast.names.get(*chosen).map_or("", String::as_str);
    ComboBox::from_label("Object").selected_text(name).show_ui(ui, |ui| {
        for (number, name) in cast.names.iter().enumerate().filter(|(k, _)| !cast.is_still[*k]) {
            ui.selectable_value(chosen, number, name.as_str());
        }
    });
    // There are none between a change of the scene and the next frame.
    let Some(hand) = edits.hands.get_mut(*chosen) else { return };
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let slider = Slider::new(&mut hand.position[axis], -4.0..=4.0).text(name).suffix(" m").fixed_decimals(2);
        // Drags go farther, and by less than the slider rounds to.
        ui.add(slider.clamping(SliderClamping::Edits));
    }
    angle(ui, &mut hand.turn, -180.0..=180.0, "Turn");
    let size = Slider::new(&mut hand.scale, 0.3..=2.0).text("Size").fixed_decimals(2);
    ui.add(size.clamping(SliderClamping::Edits));
    if ui.button("Put back").clicked() {
        edits.hands.clone_from(&cast.hands);
    }
    ui.weak("Drag an object in the picture to move it, with Shift to turn it, with Ctrl to make it larger or smaller.");
}

/// The number of spheres, and how they are fitted.
fn spheres(ui: &mut Ui, fit: &mut Fit) {
    let slider = Slider::new(&mut fit.count, 1..=MOST_SPHERES).text("Spheres of a part");
    // Each number is a fit of its own: while the handle is held, none is asked for.
    ui.add(slider.update_while_editing(false)).on_hover_text("Four times as many of a part that changes its shape");
    let ways = [
        (SphereFitMethod::Variational, "Variational", "The least volume outside of the part"),
        (SphereFitMethod::MedialAxis, "Medial axis", "Quicker, and worse"),
    ];
    for (method, title, hint) in ways {
        ui.radio_value(&mut fit.method, method, title).on_hover_text(hint);
    }
}
