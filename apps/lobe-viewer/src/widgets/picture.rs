//! Pictures of the library in the window.

use eframe::egui::{Color32, ColorImage, Rect, Response, Sense, TextureHandle, TextureOptions, Ui, Vec2, pos2};
use lobe::image::{Picture, Tone};
use web_time::Instant;

use crate::widgets::drawing_time::{has_time, note};
use crate::widgets::named::name_image;

/// A picture that is made again only when what it shows has changed.
#[derive(Default)]
pub(crate) struct PictureView {
    texture: Option<TextureHandle>,
    key: Vec<u64>,
}

impl PictureView {
    /// Shows a picture under a name at a size in points. It is made where `key` differs from that of the last time; if other pictures
    /// of the frame took too long already, in a later one.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        name: &str,
        size: Vec2,
        key: Vec<u64>,
        make: impl FnOnce() -> (Picture, Tone),
    ) -> Response {
        self.show_moved(ui, name, size, Vec2::ZERO, key, make)
    }

    /// The same with the picture moved within its place, as far as it is seen there.
    pub(crate) fn show_moved(
        &mut self,
        ui: &mut Ui,
        name: &str,
        size: Vec2,
        moved: Vec2,
        key: Vec<u64>,
        make: impl FnOnce() -> (Picture, Tone),
    ) -> Response {
        if (self.texture.is_none() || self.key != key) && has_time(ui.ctx()) {
            let begin = Instant::now();
            let (picture, tone) = make();
            let image = color_image(&picture, &tone);
            match &mut self.texture {
                Some(texture) => texture.set(image, TextureOptions::LINEAR),
                None => self.texture = Some(ui.ctx().load_texture(name, image, TextureOptions::LINEAR)),
            }
            note(ui.ctx(), 1e3 * begin.elapsed().as_secs_f64());
            self.key = key;
        } else if self.key != key {
            ui.ctx().request_repaint();
        }
        let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        name_image(&response, name);
        if let Some(texture) = &self.texture {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter_at(rect).image(texture.id(), rect.translate(moved), whole, Color32::WHITE);
        }
        response
    }
}

/// Display bytes for the window.
fn color_image(picture: &Picture, tone: &Tone) -> ColorImage {
    ColorImage::from_rgb([picture.width(), picture.height()], &tone.to_bytes(picture))
}

/// Numbers as parts of a key.
pub(crate) fn key_of(numbers: impl IntoIterator<Item = f64>) -> Vec<u64> {
    numbers.into_iter().map(f64::to_bits).collect()
}
