//! The figures of a function: balloon, unfolded cube, polar plot and coefficients.

use eframe::egui::{Align, Layout, Response, Rgba, Ui, vec2};
use lobe::figures::{CubeCross, PolarPlot};
use lobe::image::Tone;
use lobe::sh::{Dir, Rgb};

use crate::rooms::functions::edits::{FunctionsEdits, Section};
use crate::widgets::balloon::{BalloonView, Shown};
use crate::widgets::orbit::Orbit;
use crate::widgets::picture::{PictureView, key_of};

/// Height of all figures, in points; the unfolded cube is four thirds as wide.
const HEIGHT: f32 = 180.0;

/// Pixels along the edge of a face of the cube, and along the side of a polar plot: twice as many as points.
const FACE: usize = 120;
const PLOT: f64 = 360.0;

/// The pictures of one function.
#[derive(Default)]
pub(crate) struct Figures {
    balloon: BalloonView,
    cross: PictureView,
    plot: PictureView,
}

/// What the figures of a room share.
pub(crate) struct Stand<'a> {
    pub(crate) figures: &'a mut [Figures; 3],
    pub(crate) eye: &'a Orbit,
    pub(crate) has_crosses: bool,
    pub(crate) section: Section,
    /// The balloons that were shown, which the mouse turns.
    pub(crate) balloons: Vec<Response>,
}

/// A function and another that is drawn dashed beside it, if there is one.
pub(crate) struct Pair<'a> {
    pub(crate) f: &'a (dyn Fn(Dir) -> f64 + Sync),
    pub(crate) beside: Option<&'a (dyn Fn(Dir) -> f64 + Sync)>,
}

/// Figures from left to right, as many in a row as there is room for.
pub(crate) fn in_rows(ui: &mut Ui, content: impl FnOnce(&mut Ui)) {
    ui.with_layout(Layout::left_to_right(Align::Min).with_main_wrap(true), content);
}

impl<'a> Stand<'a> {
    pub(crate) fn new(edits: &FunctionsEdits, eye: &'a Orbit, figures: &'a mut [Figures; 3]) -> Self {
        let (has_crosses, section) = (edits.has_crosses, edits.section);
        Self { figures, eye, has_crosses, section, balloons: Vec::new() }
    }

    /// Shows the figures of function number `number` beside each other. `balloon` names the balloon, `key` has all numbers on which
    /// both functions depend, `extent` is the value that reaches the border.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        number: usize,
        (name, balloon): (&str, &str),
        pair: &Pair<'_>,
        (key, extent): (&[f64], Option<f64>),
    ) {
        let figures = &mut self.figures[number];
        let shown = Shown { name: balloon, key, f: pair.f, extent };
        self.balloons.push(figures.balloon.show_moved(ui, HEIGHT, self.eye, &shown));
        let back = Rgba::from(ui.visuals().panel_fill);
        let background = Rgb::new(back.r(), back.g(), back.b());
        let numbers = key.iter().copied().chain([extent.unwrap_or(0.0), f64::from(back.r())]);
        let key = key_of(numbers);
        if self.has_crosses {
            let title = format!("Unfolded cube of {name}");
            let size = vec2(HEIGHT * 4.0 / 3.0, HEIGHT);
            let shown = figures.cross.show(ui, &title, size, key.clone(), || {
                let cross = CubeCross { full_scale: extent, background, ..CubeCross::new(FACE) };
                (cross.picture(pair.f), Tone::PLAIN)
            });
            shown.on_hover_text(
                "The cube seen from inside; red positive, blue negative, lines of equal value, green is zero",
            );
        }
        if let Some(section) = self.section.plane() {
            let title = format!("Polar plot of {name}, {}", self.section.title());
            let key = [key, vec![self.section as u64]].concat();
            let shown = figures.plot.show(ui, &title, vec2(HEIGHT, HEIGHT), key, || {
                let plot = PolarPlot { extent, ..PolarPlot::new(PLOT, section) };
                let beside: Vec<&dyn Fn(Dir) -> f64> = pair.beside.iter().map(|f| *f as &dyn Fn(Dir) -> f64).collect();
                (plot.picture(&|s| (pair.f)(s), &beside), Tone::PLAIN)
            });
            shown.on_hover_text("The distance is |f|; dashed is the function before");
        }
    }
}
