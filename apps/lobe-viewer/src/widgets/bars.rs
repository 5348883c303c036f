//! Coefficients as bars, band by band.

use eframe::egui::{Color32, Pos2, Rect, Sense, Stroke, Ui, Vec2};
use lobe::sh::{Expansion as _, ShVec};

use crate::widgets::named::name_image;

/// Height of a row of bars, in points.
const ROW: f32 = 34.0;

/// The widest bar.
const WIDEST: f32 = 22.0;

const RED: Color32 = Color32::from_rgb(214, 72, 56);
const BLUE: Color32 = Color32::from_rgb(62, 120, 214);

/// Bars in a pyramid: a row for each band, red upwards and blue downwards, with the square root of the energy of the band beside it.
pub(crate) fn bars(ui: &mut Ui, name: &str, f: &ShVec<f64>) {
    let order = f.order();
    let largest = f.coefficients().iter().fold(1e-12_f64, |most, c| most.max(c.abs()));
    let width = ui.available_width().min(320.0);
    let size = Vec2::new(width, ROW * order as f32);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    name_image(&response, name);
    let painter = ui.painter_at(rect);
    let color = ui.visuals().text_color();
    let label_width = 74.0;
    let cell = ((width - label_width) / (2 * order).saturating_sub(1).max(1) as f32).min(WIDEST + 4.0);
    let middle = rect.left() + 0.5 * (width - label_width);
    for (l, energy) in f.band_energies().iter().enumerate() {
        let zero = rect.top() + ROW * (l as f32 + 0.5);
        let at = Pos2::new(rect.right() - label_width, zero);
        let text = format!("l {l}  {:.3}", energy.sqrt());
        painter.text(at, eframe::egui::Align2::LEFT_CENTER, text, eframe::egui::FontId::monospace(11.0), color);
        for (k, c) in f.band(l).iter().enumerate() {
            let x = middle + cell * (k as f32 - l as f32);
            let height = (c / largest) as f32 * 0.45 * ROW;
            let bar = Rect::from_two_pos(Pos2::new(x - 0.4 * cell, zero), Pos2::new(x + 0.4 * cell, zero - height));
            painter.rect_filled(bar, 1.0, if *c > 0.0 { RED } else { BLUE });
            let base = [Pos2::new(x - 0.4 * cell, zero), Pos2::new(x + 0.4 * cell, zero)];
            painter.line_segment(base, Stroke::new(1.0, color.gamma_multiply(0.4)));
        }
    }
}
