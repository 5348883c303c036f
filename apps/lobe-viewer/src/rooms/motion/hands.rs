//! Objects that a user takes by the hand: which one is under the pointer, and what a drag does to it.

use eframe::egui::{Modifiers, Pos2, Rect, vec2};

use crate::rooms::motion::cast::{Cast, Hand};
use crate::rooms::motion::edits::SCALES;
use crate::widgets::orbit::Orbit;

/// Moves an object along the picture by a drag, in parts of its height; with Shift it turns, with Ctrl it grows or shrinks.
pub(crate) fn drag(hand: &mut Hand, orbit: &Orbit, modifiers: Modifiers, [right, down]: [f64; 2]) {
    if modifiers.shift {
        hand.turn += std::f64::consts::TAU * right;
        return;
    }
    if modifiers.command {
        hand.scale = (hand.scale * (-2.0 * down).exp()).clamp(*SCALES.start(), *SCALES.end());
        return;
    }
    let (Some(size), Some(camera)) = (orbit.size_at(hand.position), orbit.camera()) else { return };
    let by = camera.view().point([2.0 * right / size, -2.0 * down / size, 0.0]);
    (0..3).for_each(|k| hand.position[k] += by[k]);
}

/// The object whose ball is under a point of the picture, the nearest to the eye.
pub(crate) fn object_at(hands: &[Hand], cast: &Cast, orbit: &Orbit, rect: Rect, at: Pos2) -> Option<usize> {
    let half = 0.5 * rect.height();
    let size = |k: &usize| orbit.size_at(hands[*k].position);
    let is_hit = |k: &usize| {
        let (Some([right, up]), Some(size)) = (orbit.project(hands[*k].position), size(k)) else { return false };
        let place = rect.center() + vec2(right as f32, -up as f32) * half;
        place.distance(at) <= (cast.radii[*k] * hands[*k].scale * size) as f32 * half
    };
    let nearer = |a: &usize, b: &usize| size(a).unwrap_or(0.0).total_cmp(&size(b).unwrap_or(0.0));
    let count = hands.len().min(cast.is_still.len());
    (0..count).filter(|k| !cast.is_still[*k]).filter(is_hit).max_by(nearer)
}
