//! Functions on the sphere as balloons that can be turned.

use eframe::egui::{Response, Rgba, Ui, Vec2};
use lobe::figures::Balloon;
use lobe::image::Tone;
use lobe::render::View;
use lobe::sh::sphere::even_directions;
use lobe::sh::{Dir, Rgb};

use crate::widgets::orbit::Orbit;
use crate::widgets::picture::{PictureView, key_of};

/// Rows and columns of the pictures.
const PIXELS: usize = 224;

/// While a balloon is dragged, of a coarser one.
const COARSE: usize = 112;

/// Directions among which the largest value is looked for.
const DIRECTIONS: usize = 2048;

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
    /// Shows a function in a square of `side` points, as large as fits.
    pub(crate) fn show<F: Fn(Dir) -> f64 + Sync>(
        &mut self,
        ui: &mut Ui,
        side: f32,
        eye: &Orbit,
        shown: &Shown<'_, F>,
    ) -> Response {
        self.draw(ui, side, eye, shown, (1.0, Vec2::ZERO))
    }

    /// The same as an eye sees it that may have come nearer than that of the first start, and moved.
    pub(crate) fn show_moved<F: Fn(Dir) -> f64 + Sync>(
        &mut self,
        ui: &mut Ui,
        side: f32,
        eye: &Orbit,
        shown: &Shown<'_, F>,
    ) -> Response {
        let [right, up] = eye.project([0.0; 3]).unwrap_or_default().map(|c| c as f32 * 0.5 * side);
        self.draw(ui, side, eye, shown, (Orbit::default().distance / eye.distance, Vec2::new(right, -up)))
    }

    fn draw<F: Fn(Dir) -> f64 + Sync>(
        &mut self,
        ui: &mut Ui,
        side: f32,
        eye: &Orbit,
        shown: &Shown<'_, F>,
        (zoom, moved): (f64, Vec2),
    ) -> Response {
        let back = Rgba::from(ui.visuals().panel_fill);
        let is_moving = ui.input(|input| input.pointer.is_decidedly_dragging());
        let size = if is_moving { COARSE } else { PIXELS };
        let mut key = key_of([eye.azimuth, eye.height, shown.extent.unwrap_or(0.0), f64::from(back.r()), size as f64]);
        key.extend(key_of(shown.key.iter().copied().chain([zoom])));
        let view = View::from_eye(eye.towards_eye());
        self.picture.show_moved(ui, shown.name, Vec2::splat(side), moved, key, || {
            let largest = || even_directions(DIRECTIONS).map(|s| (shown.f)(s).abs()).fold(0.0, f64::max);
            let extent = if zoom == 1.0 { shown.extent } else { Some(shown.extent.unwrap_or_else(largest) / zoom) };
            let balloon =
                Balloon { view, extent, background: Rgb::new(back.r(), back.g(), back.b()), ..Balloon::new(size) };
            (balloon.picture(&shown.f), Tone::PLAIN)
        })
    }
}
