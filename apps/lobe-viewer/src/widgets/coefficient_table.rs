//! Coefficients as a table whose cells can be typed into.

use eframe::egui::{CollapsingHeader, ProgressBar, Response, TextEdit, Ui};
use lobe::sh::{Expansion as _, Rgb, ShVec};

/// Width of a cell and of a bar, in points.
const CELL: f32 = 66.0;
const BAR: f32 = 120.0;

/// A cell takes numbers up to this: light beyond it is none of a picture, and its squares still have digits.
pub(crate) const MOST: f64 = 1e6;

/// The names of the channels.
const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// A coefficient and its new value.
pub(crate) type Changed = (usize, Rgb<f64>);

/// What is being typed, and why the last was refused.
#[derive(Debug, Default)]
pub(crate) struct CoefficientTable {
    typed: Option<(Cell, String)>,
    refused: Option<String>,
}

/// Coefficient and channel.
type Cell = (usize, usize);

impl CoefficientTable {
    /// Shows a row for each coefficient under a bar for each band, whose length is the square root of its energy. Returns what was
    /// typed; what is no number is refused in words, and the cell keeps its value.
    pub(crate) fn show(&mut self, ui: &mut Ui, f: &ShVec<Rgb<f64>>, is_editable: bool) -> Option<Changed> {
        let norms: Vec<f64> = f.map(Rgb::luminance).band_energies().iter().map(|energy| energy.sqrt()).collect();
        let most = norms.iter().fold(1e-12_f64, |most, norm| most.max(*norm));
        let typed = self.typed.take();
        let mut changed = None;
        for (l, norm) in norms.iter().enumerate() {
            let bar = ProgressBar::new((norm / most) as f32).desired_width(BAR).text(format!("{norm:.3}"));
            CollapsingHeader::new(format!("Band {l}")).default_open(l < 2).show(ui, |ui| {
                ui.add(bar).on_hover_text("The square root of the energy of the luminance in this band");
                for k in l * l..(l + 1) * (l + 1) {
                    changed = self.row(ui, (l, k), f.coefficients()[k], typed.as_ref(), is_editable).or(changed);
                }
            });
        }
        if let Some(refused) = &self.refused {
            ui.colored_label(ui.visuals().error_fg_color, refused);
        }
        changed
    }

    fn row(
        &mut self,
        ui: &mut Ui,
        (l, k): (usize, usize),
        color: Rgb<f64>,
        typed: Option<&(Cell, String)>,
        is_editable: bool,
    ) -> Option<Changed> {
        let m = k as isize - (l * l + l) as isize;
        let values = <[f64; 3]>::from(color);
        let mut changed = None;
        ui.horizontal(|ui| {
            ui.monospace(format!("{m:>2}"));
            for (channel, name) in CHANNELS.into_iter().enumerate() {
                let shown = format!("{:.4}", values[channel]);
                let is_typed = typed.filter(|(cell, _)| *cell == (k, channel));
                let mut text = is_typed.map_or_else(|| shown.clone(), |(_, text)| text.clone());
                let edit = TextEdit::singleline(&mut text).desired_width(CELL).interactive(is_editable);
                let response = ui.add(edit);
                let title = format!("Band {l}, {m}, {name}");
                ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(title.as_str()));
                let Some(value) = self.take(&response, (k, channel), text, &shown, &title) else { continue };
                let mut new = values;
                new[channel] = value;
                changed = Some((k, Rgb::from(new)));
            }
        });
        changed
    }

    /// The number in a cell that was left.
    fn take(&mut self, response: &Response, cell: Cell, text: String, shown: &str, title: &str) -> Option<f64> {
        if response.has_focus() {
            self.typed = Some((cell, text));
            return None;
        }
        if !response.lost_focus() || text.trim() == shown {
            return None;
        }
        let read = text.trim().parse::<f64>().ok().filter(|value| value.abs() <= MOST);
        self.refused = read.is_none().then(|| {
            format!("{title}: expected a number from -1000000 to 1000000, found '{}'; it remains {shown}", text.trim())
        });
        read
    }
}
