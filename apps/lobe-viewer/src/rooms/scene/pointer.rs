//! Mouse input in the picture: orbit, pan, zoom, and turning the sky.

use eframe::egui::{Modifiers, PointerButton, Response, Ui};

use crate::rooms::scene::edits::SceneEdits;
use crate::widgets::orbit::Orbit;

/// A drag turns the view, with Shift the sky, with Ctrl or the right or middle button it moves the view; scrolling zooms.
pub(crate) fn follow(ui: &Ui, response: &Response, orbit: &mut Orbit, edits: &mut SceneEdits) {
    let height = f64::from(response.rect.height().max(1.0));
    let [right, down] = [response.drag_delta().x, response.drag_delta().y].map(|c| f64::from(c) / height);
    let Modifiers { shift, command, .. } = ui.input(|input| input.modifiers);
    if response.dragged_by(PointerButton::Primary) {
        if shift {
            turn_sky(edits, right, down);
        } else if command {
            orbit.pan(right, down);
        } else {
            orbit.turn(right, down);
        }
    } else if response.dragged_by(PointerButton::Secondary) || response.dragged_by(PointerButton::Middle) {
        orbit.pan(right, down);
    }
    if response.hovered() {
        let (scrolled, pinched) = ui.input(|input| (input.smooth_scroll_delta.y, input.zoom_delta()));
        orbit.scroll(f64::from(scrolled));
        orbit.zoom(f64::from(pinched));
    }
}

/// Turns the sky by a drag in parts of the height of the picture.
pub(crate) fn turn_sky(edits: &mut SceneEdits, right: f64, down: f64) {
    use std::f64::consts::{PI, TAU};
    edits.turn = (edits.turn + PI * right).rem_euclid(TAU);
    edits.tilt = (edits.tilt + PI * down).clamp(-PI, PI);
}
