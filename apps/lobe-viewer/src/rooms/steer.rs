//! The camera and the light by hand, in every room the same: by the mouse and by keys.

use eframe::egui::{Context, EventFilter, Id, Key, Memory, Modifiers, PointerButton, Response, Stroke, StrokeKind, Ui};

use crate::rooms::light::LightHand;
use crate::widgets::orbit::Orbit;

/// Parts of the height of the picture by which an arrow key turns or moves: turns are 5 degrees.
const STEP: f64 = 1.0 / 36.0;

/// The factor by which a key comes nearer.
const ZOOM: f64 = 1.1;

/// Keys of a camera that a room answers itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Pressed {
    /// All that there is in the picture.
    pub(crate) frame: bool,
    /// The sky keeps turning, or no longer.
    pub(crate) turning: bool,
}

/// A drag turns the view, with Shift the sky, with Ctrl or the right or middle button it moves the view; scrolling zooms.
pub(crate) fn pointer(ui: &Ui, response: &Response, orbit: &mut Orbit, light: &mut LightHand<'_>) {
    let [right, down] = drag_of(response);
    let Modifiers { shift, command, .. } = ui.input(|input| input.modifiers);
    if response.dragged_by(PointerButton::Primary) {
        if shift {
            light.turn_by(right, down);
        } else if command {
            orbit.pan(right, down);
        } else {
            orbit.turn(right, down);
        }
    } else if response.dragged_by(PointerButton::Secondary) || response.dragged_by(PointerButton::Middle) {
        orbit.pan(right, down);
    }
    zoom(ui, response, orbit);
}

/// Scrolling and pinching come nearer, where the pointer is on the picture.
pub(crate) fn zoom(ui: &Ui, response: &Response, orbit: &mut Orbit) {
    if response.hovered() {
        let (scrolled, pinched) = ui.input(|input| (input.smooth_scroll_delta.y, input.zoom_delta()));
        orbit.scroll(f64::from(scrolled));
        orbit.zoom(f64::from(pinched));
    }
}

/// A drag to the right and down, in parts of the height of the picture.
pub(crate) fn drag_of(response: &Response) -> [f64; 2] {
    let height = f64::from(response.rect.height().max(1.0));
    [response.drag_delta().x, response.drag_delta().y].map(|c| f64::from(c) / height)
}

/// Whether keys are for the pictures of a room: no control has the keyboard, or one of these pictures has.
pub(crate) fn has_keys(ctx: &Context, pictures: &[Id]) -> bool {
    ctx.memory(Memory::focused).is_none_or(|focused| pictures.contains(&focused))
}

/// Keeps the arrow keys for a picture that has the keyboard, and shows that it has.
pub(crate) fn hold_keys(ui: &Ui, response: &Response) {
    if response.has_focus() {
        let arrows = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
        let stroke = Stroke::new(2.0, ui.visuals().selection.bg_fill);
        ui.painter().rect_stroke(response.rect, 0.0, stroke, StrokeKind::Inside);
    }
}

/// Arrows do what a drag does, with the same keys held; plus and minus come nearer and go away; comma, point, brackets, W and D
/// change the light.
pub(crate) fn keys(ctx: &Context, orbit: &mut Orbit, light: &mut LightHand<'_>) -> Pressed {
    let (times, Modifiers { shift, command, alt, .. }) = ctx.input(|input| {
        let arrows = [Key::ArrowLeft, Key::ArrowRight, Key::ArrowUp, Key::ArrowDown];
        (arrows.map(|key| input.num_presses(key) as f64), input.modifiers)
    });
    let [right, down] = [times[1] - times[0], times[3] - times[2]].map(|presses| STEP * presses);
    if [right, down] != [0.0; 2] && !alt {
        match (shift, command) {
            (true, _) => light.turn_by(right, down),
            (_, true) => orbit.pan(right, down),
            _ => orbit.turn(right, down),
        }
    }
    let presses = |all: &[Key]| ctx.input(|input| all.iter().map(|key| input.num_presses(*key)).sum::<usize>()) as i32;
    if !command {
        orbit.zoom(ZOOM.powi(presses(&[Key::Plus, Key::Equals]) - presses(&[Key::Minus])));
    }
    let pressed = |key: Key| ctx.input(|input| input.modifiers.is_none() && input.key_pressed(key));
    light.change_order(isize::from(pressed(Key::Period)) - isize::from(pressed(Key::Comma)));
    light.change_exposure(f64::from(pressed(Key::CloseBracket)) - f64::from(pressed(Key::OpenBracket)));
    if pressed(Key::W) {
        light.next_window();
    }
    if pressed(Key::D) {
        light.switch_dering();
    }
    Pressed { frame: pressed(Key::F), turning: pressed(Key::T) }
}
