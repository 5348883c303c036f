//! Functions on the sphere as balloons that can be turned.

use eframe::egui::{Response, Rgba, Ui, Vec2};
use lobe::image::Tone;
use lobe::render::{Balloon, View};
use lobe::sh::{Dir, Rgb};

use crate::widgets::orbit::Orbit;
use crate::widgets::picture::{PictureView, key_of};

/// Rows and columns of the pictures.
const PIXELS: usize = 224;

/// While a balloon is dragged, of a coarser one.
const COARSE: usize = 112;

/// The surface `r = |f(s)|`, red where `f` is positive and blue where it is negative, seen by an eye that all balloons of a room
/// share.
#[derive(Default)]
pub(crate) struct BalloonView {
    picture: PictureView,
}

/// What a balloon shows.
pub(crate) struct Shown<'a, F> {
    /// The name for people.
    pub(crate) name: &'a str,
    /// The numbers on which the function depends.
    pub(crate) key: &'a [f64],
    /// The function.
    pub(crate) f: F,
    /// The value that reaches the border; without one, the largest that occurs.
    pub(crate) extent: Option<f64>,
}

impl BalloonView {
    /// Shows a function in a square of `side` points; dragging turns `eye`.
    pub(crate) fn show<F: Fn(Dir) -> f64 + Sync>(
        &mut self,
        ui: &mut Ui,
        side: f32,
        eye: &mut Orbit,
        shown: &Shown<'_, F>,
    ) -> Response {
        let back = Rgba::from(ui.visuals().panel_fill);
        let is_moving = ui.input(|input| input.pointer.is_decidedly_dragging());
        let size = if is_moving { COARSE } else { PIXELS };
        let mut key = key_of([eye.azimuth, eye.height, shown.extent.unwrap_or(0.0), f64::from(back.r()), size as f64]);
        key.extend(key_of(shown.key.iter().copied()));
        let view = View::from_eye(eye.towards_eye());
        let response = self.picture.show(ui, shown.name, Vec2::splat(side), key, || {
            let balloon = Balloon {
                view,
                extent: shown.extent,
                background: Rgb::new(back.r(), back.g(), back.b()),
                ..Balloon::new(size)
            };
            (balloon.picture(&shown.f), Tone::PLAIN)
        });
        if response.dragged() {
            let by = response.drag_delta() / side;
            eye.turn(f64::from(by.x), f64::from(by.y));
        }
        response
    }
}
