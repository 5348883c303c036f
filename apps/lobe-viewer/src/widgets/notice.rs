//! A line that comes up over the window: what was done, or what went wrong.

use eframe::egui::{Align2, Area, Context, Frame, Id};

/// Seconds for which what was done is shown; what went wrong remains until it is closed.
const SECONDS: f64 = 6.0;

/// The line, if there is one.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Notice(Option<Said>);

#[derive(Clone, Debug, PartialEq)]
struct Said {
    text: String,
    is_error: bool,
    /// When it was first shown.
    since: Option<f64>,
}

impl Notice {
    /// Says what was done.
    pub(crate) fn tell(&mut self, text: impl Into<String>) {
        self.0 = Some(Said { text: text.into(), is_error: false, since: None });
    }

    /// Says what went wrong.
    pub(crate) fn fail(&mut self, text: impl Into<String>) {
        self.0 = Some(Said { text: text.into(), is_error: true, since: None });
    }

    /// What is said.
    pub(crate) fn text(&self) -> Option<&str> {
        self.0.as_ref().map(|said| said.text.as_str())
    }

    /// Shows it in the lower right corner.
    pub(crate) fn show(&mut self, ctx: &Context) {
        let Some(said) = &mut self.0 else { return };
        let now = ctx.input(|input| input.time);
        let left = SECONDS - (now - *said.since.get_or_insert(now));
        let mut is_closed = !said.is_error && left <= 0.0;
        let area = Area::new(Id::unique("notice")).anchor(Align2::RIGHT_BOTTOM, [-12.0, -40.0]);
        area.show(ctx, |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.horizontal(|ui| {
                    if said.is_error {
                        ui.colored_label(ui.visuals().error_fg_color, &said.text);
                    } else {
                        ui.label(&said.text);
                    }
                    is_closed |= ui.small_button("Close").clicked();
                });
            });
        });
        if is_closed {
            self.0 = None;
        } else if !said.is_error {
            ctx.request_repaint_after(std::time::Duration::from_secs_f64(left.max(0.0)));
        }
    }
}
