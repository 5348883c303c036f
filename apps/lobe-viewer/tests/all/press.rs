//! Controls pressed as a hand presses them: lists, sliders, the mouse on a picture.

use eframe::egui::accesskit::Role;
use eframe::egui::{
    Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, TouchPhase, Vec2, vec2,
};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;

/// Opens a list by its name and chooses an entry.
pub(crate) fn choose<S>(harness: &mut Harness<'_, S>, list: &str, entry: &str) {
    harness.get_by_role_and_label(Role::ComboBox, list).click();
    harness.run_steps(2);
    // An entry that is farther down than the list is high cannot be pointed at.
    harness.get_by_label(entry).click_accesskit();
    harness.run_steps(1);
    harness.key_press(Key::Escape);
    harness.run_steps(3);
}

/// Brings a slider to a value.
pub(crate) fn slide<S>(harness: &mut Harness<'_, S>, slider: &str, value: f64) {
    harness.get_by_role_and_label(Role::Slider, slider).set_value_accesskit(value);
    harness.run_steps(2);
}

/// Drags from a place, in one step beyond that which tells a drag from a click; all of it counts.
pub(crate) fn drag<S>(
    harness: &mut Harness<'_, S>,
    from: Pos2,
    by: Vec2,
    (button, modifiers): (PointerButton, Modifiers),
) {
    harness.event(Event::PointerMoved(from));
    harness.event(Event::ModifiersChanged(modifiers));
    harness.event(Event::PointerButton { pos: from, button, pressed: true, modifiers });
    harness.event(Event::PointerMoved(from + by));
    harness.event(Event::PointerButton { pos: from + by, button, pressed: false, modifiers });
    harness.event(Event::ModifiersChanged(Modifiers::NONE));
    harness.run_steps(2);
}

/// Turns the wheel over a place.
pub(crate) fn scroll<S>(harness: &mut Harness<'_, S>, at: Pos2, points: f32) {
    harness.event(Event::PointerMoved(at));
    harness.event(Event::MouseWheel {
        unit: MouseWheelUnit::Point,
        delta: vec2(0.0, points),
        phase: TouchPhase::Move,
        source: MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(20);
}
