//! The keys, and what the mouse does.

use eframe::egui::{Context, Grid, ScrollArea, Ui, Window};

/// What is pressed and what it does.
const KEYS: [(&str, &str); 25] = [
    ("Drag, arrows", "turn the view, or a balloon"),
    ("Shift + drag, Shift + arrows", "turn the sky, or the function"),
    ("Ctrl + drag, Ctrl + arrows, right drag", "move the view"),
    ("Scroll, plus, minus", "come nearer, go away"),
    ("F", "the whole scene in the picture"),
    ("T", "the sky keeps turning"),
    ("1 2 3 4", "light paths, pictures below the sky, studies, or ways of shadows"),
    (", .", "lower, higher order"),
    ("[ ]", "less, more exposure"),
    ("W", "the next window of the expansion"),
    ("D", "dering on, off"),
    ("Space", "play, stop (room of motion)"),
    ("Click on a sun", "take it out of the sky (room of skies)"),
    ("R", "the truth by rays, the difference to it"),
    ("P", "transfer under the pointer"),
    ("Ctrl + O", "open a file"),
    ("Ctrl + Z", "take a change back"),
    ("Ctrl + Shift + Z, Ctrl + Y", "make it again"),
    ("F12", "the window as a picture"),
    ("Ctrl + E", "pictures and turntables of the scene"),
    ("Ctrl + 1 2 3 4", "the rooms"),
    ("Ctrl + plus, minus", "larger, smaller"),
    ("Esc", "stop what is under way"),
    ("Tab, arrows, Space", "go to a control, change it, press it"),
    ("F1", "this list"),
];

/// Points that the window of the list, its title and its margins need around it.
const AROUND: [f32; 2] = [60.0, 120.0];

/// The list has at least so many points along each side.
const LEAST: f32 = 60.0;

/// Shows the list.
pub(crate) fn help(ctx: &Context, is_open: &mut bool) {
    Window::new("Keys and mouse").open(is_open).resizable(false).show(ctx, |ui| {
        // What does not fit a small window is scrolled to, in both directions.
        let [width, height] = [ctx.content_rect().width(), ctx.content_rect().height()];
        let most = [width - AROUND[0], height - AROUND[1]].map(|side| side.max(LEAST));
        ScrollArea::both().max_width(most[0]).max_height(most[1]).show(ui, keys);
    });
}

fn keys(ui: &mut Ui) {
    Grid::new("keys").num_columns(2).spacing([24.0, 4.0]).striped(true).show(ui, |ui| {
        for (key, does) in KEYS {
            ui.strong(key);
            ui.label(does);
            ui.end_row();
        }
    });
}
