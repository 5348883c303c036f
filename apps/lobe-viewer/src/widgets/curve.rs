//! Curves over an angle or over bands.

use eframe::egui::{Align2, Color32, FontId, Pos2, Rect, Sense, Stroke, Ui, Vec2};

use crate::widgets::named::name_image;

/// Points of a curve.
const POINTS: usize = 240;

/// A curve and how it is drawn.
pub(crate) struct Curve<'a> {
    pub(crate) name: &'a str,
    pub(crate) color: Color32,
    pub(crate) f: &'a dyn Fn(f64) -> f64,
}

/// What is along the curves, from 0 to `end`.
pub(crate) struct Axis {
    end: f64,
    /// Equal parts, with a number at each end.
    parts: usize,
    number: fn(f64) -> String,
}

impl Axis {
    /// Angles up to `end` radians, in degrees.
    pub(crate) fn angles(end: f64) -> Self {
        Self { end, parts: 4, number: |radians| format!("{:.0}°", radians.to_degrees()) }
    }

    /// The bands below an order.
    pub(crate) fn bands(order: usize) -> Self {
        let last = order.saturating_sub(1);
        Self { end: last as f64, parts: last, number: |l| format!("l = {l:.0}") }
    }
}

/// Curves along an axis, with a line at zero, the range of values and a key.
pub(crate) fn curves(ui: &mut Ui, name: &str, size: Vec2, axis: &Axis, curves: &[Curve<'_>]) {
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    name_image(&response, name);
    let painter = ui.painter_at(rect);
    let text = ui.visuals().text_color();
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    let place = |k: usize| axis.end * k as f64 / (POINTS - 1) as f64;
    let values: Vec<Vec<f64>> = curves.iter().map(|curve| (0..POINTS).map(|k| (curve.f)(place(k))).collect()).collect();
    let all = || values.iter().flatten().copied().filter(|y| y.is_finite());
    let (low, high) = all().fold((0.0_f64, 1e-9_f64), |(low, high), y| (low.min(y), high.max(y)));
    let (low, high) = (low - 0.06 * (high - low), high + 0.12 * (high - low));
    let plot = Rect::from_min_max(rect.min + Vec2::new(46.0, 8.0), rect.max - Vec2::new(10.0, 22.0));
    let y_of = |y: f64| plot.bottom() - plot.height() * ((y - low) / (high - low)) as f32;
    let x_of = |k: usize| plot.left() + plot.width() * k as f32 / (POINTS - 1) as f32;
    painter.hline(plot.x_range(), y_of(0.0), Stroke::new(1.0, text.gamma_multiply(0.5)));
    let font = FontId::proportional(11.0);
    for (y, align) in [(0.0, Align2::RIGHT_CENTER), (high, Align2::RIGHT_TOP)] {
        painter.text(Pos2::new(plot.left() - 4.0, y_of(y)), align, format!("{y:.2}"), font.clone(), text);
    }
    for tick in 0..=axis.parts {
        let part = tick as f64 / axis.parts.max(1) as f64;
        let (x, number) = (plot.left() + plot.width() * part as f32, (axis.number)(axis.end * part));
        painter.text(Pos2::new(x, plot.bottom() + 3.0), Align2::CENTER_TOP, number, font.clone(), text);
    }
    for (curve, values) in curves.iter().zip(&values) {
        let points = values.iter().enumerate().map(|(k, y)| Pos2::new(x_of(k), y_of(*y))).collect();
        painter.line(points, Stroke::new(1.8, curve.color));
    }
    for (row, curve) in curves.iter().enumerate() {
        let at = Pos2::new(plot.right() - 4.0, plot.top() + 14.0 * row as f32);
        painter.text(at, Align2::RIGHT_TOP, curve.name, font.clone(), curve.color);
    }
}
