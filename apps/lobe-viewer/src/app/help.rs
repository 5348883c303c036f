//! The keys, and what the mouse does.

use eframe::egui::{Context, Grid, Window};

/// What is pressed and what it does.
const KEYS: [(&str, &str); 21] = [
    ("Drag", "turn the view, or a balloon"),
    ("Shift + drag", "turn the sky"),
    ("Ctrl + drag, right drag", "move the view"),
    ("Scroll", "come nearer, go away"),
    ("F", "the whole scene in the picture"),
    ("T", "the sky keeps turning"),
    ("1 2 3 4", "unshadowed, shadowed, interreflected, difference"),
    (", .", "lower, higher order"),
    ("[ ]", "less, more exposure"),
    ("R", "the truth by rays, the difference to it"),
    ("P", "transfer under the pointer"),
    ("Ctrl + O", "open a file"),
    ("Ctrl + Z", "take a change back"),
    ("Ctrl + Shift + Z", "make it again"),
    ("F12", "the window as a picture"),
    ("Ctrl + E", "pictures and turntables of the scene"),
    ("Ctrl + 1 2 3 4", "the rooms"),
    ("Ctrl + plus, minus", "larger, smaller"),
    ("Esc", "stop what is under way"),
    ("Tab, arrows, Space", "go to a control, change it, press it"),
    ("F1", "this list"),
];

/// Shows the list.
pub(crate) fn help(ctx: &Context, is_open: &mut bool) {
    Window::new("Keys and mouse").open(is_open).resizable(false).show(ctx, |ui| {
        Grid::new("keys").num_columns(2).spacing([24.0, 4.0]).striped(true).show(ui, |ui| {
            for (key, does) in KEYS {
                ui.strong(key);
                ui.label(does);
                ui.end_row();
            }
        });
    });
}
