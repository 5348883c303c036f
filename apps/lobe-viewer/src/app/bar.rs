//! The bar above the rooms.

use std::path::PathBuf;

use eframe::egui::{Button, Slider, Ui};

use crate::app::kept::{Kept, Theme};
use crate::loading::place::IN_PAGE;
use crate::rooms::rooms::RoomName;
use crate::widgets::history::{Can, Step};

/// What a user asks for in the bar.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum BarAsked {
    Open,
    OpenRecent(PathBuf),
    Step(Step),
    Help,
    Export,
    Shoot,
    Reset,
}

/// Shows the bar. `can` says what can be done with the changes of the room that is open.
pub(crate) fn bar(ui: &mut Ui, kept: &mut Kept, can: Can) -> Option<BarAsked> {
    let mut asked = None;
    ui.horizontal_wrapped(|ui| {
        for (number, room) in RoomName::ALL.into_iter().enumerate() {
            let hint = format!("Ctrl+{}", number + 1);
            ui.selectable_value(&mut kept.room, room, room.title()).on_hover_text(hint);
        }
        ui.separator();
        ui.menu_button("File", |ui| {
            if ui.button("Open a file").clicked() {
                asked = Some(BarAsked::Open);
            }
            for path in &kept.recent {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
                    asked = Some(BarAsked::OpenRecent(path.clone()));
                }
            }
            if ui.button("Start afresh").on_hover_text("Everything as at the first start").clicked() {
                asked = Some(BarAsked::Reset);
            }
        });
        ui.menu_button("Window", |ui| {
            for (theme, title) in [(Theme::System, "As the system"), (Theme::Dark, "Dark"), (Theme::Light, "Light")] {
                ui.radio_value(&mut kept.theme, theme, title);
            }
            let mut percent = 100.0 * kept.zoom;
            let slider = Slider::new(&mut percent, 75.0..=200.0).step_by(25.0).suffix(" %").text("Size");
            // While the handle is held, the slider would move away under it.
            if ui.add(slider.update_while_editing(false)).drag_stopped() || !ui.input(|input| input.pointer.any_down())
            {
                kept.zoom = percent / 100.0;
            }
        });
        if ui.add_enabled(can.undo, Button::new("Undo")).on_hover_text("Ctrl+Z").clicked() {
            asked = Some(BarAsked::Step(Step::Undo));
        }
        if ui.add_enabled(can.redo, Button::new("Redo")).on_hover_text("Ctrl+Shift+Z").clicked() {
            asked = Some(BarAsked::Step(Step::Redo));
        }
        // A page has no folder for files.
        if !IN_PAGE
            && ui.button("Screenshot").on_hover_text("The window as PNG, into the folder of Export (F12)").clicked()
        {
            asked = Some(BarAsked::Shoot);
        }
        if !IN_PAGE && ui.button("Export").on_hover_text("The scene as a picture or a turntable (Ctrl+E)").clicked() {
            asked = Some(BarAsked::Export);
        }
        if ui.button("Keys").on_hover_text("F1").clicked() {
            asked = Some(BarAsked::Help);
        }
    });
    asked
}
