//! The keys, and what the mouse does.

use eframe::egui::{Context, Frame, Grid, Label, Margin, RichText, ScrollArea, Ui, Window};

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

/// Points to the right of the list: the bar that scrolls lies over what is scrolled.
const OF_BAR: i8 = 12;

/// Shows the list. In a small window its lines wrap, and it scrolls.
pub(crate) fn help(ctx: &Context, is_open: &mut bool) {
    let [width, height] = [ctx.content_rect().width(), ctx.content_rect().height()];
    let [width, height] = [width - AROUND[0], height - AROUND[1]].map(|side| side.max(LEAST));
    Window::new("Keys and mouse").open(is_open).resizable(false).show(ctx, |ui| {
        // Without a least height the list would be as low as new windows are.
        let list = ScrollArea::vertical().max_height(height).min_scrolled_height(height);
        let beside_bar = Frame::NONE.inner_margin(Margin { right: OF_BAR, ..Margin::ZERO });
        list.show(ui, |ui| beside_bar.show(ui, |ui| keys(ui, width)));
    });
}

fn keys(ui: &mut Ui, width: f32) {
    let grid = Grid::new("keys").num_columns(2).spacing([24.0, 4.0]).striped(true);
    // What is done has the longer texts.
    let [of_keys, of_doing] = [0.4, 0.55].map(|part| part * width);
    grid.show(ui, |ui| {
        for (key, does) in KEYS {
            wrapped(ui, RichText::new(key).strong(), of_keys);
            wrapped(ui, RichText::new(does), of_doing);
            ui.end_row();
        }
    });
}

/// A text of at most this width, in as many lines as it takes.
fn wrapped(ui: &mut Ui, text: RichText, width: f32) {
    ui.vertical(|ui| {
        ui.set_max_width(width);
        ui.add(Label::new(text).wrap());
    });
}
