//! Pictures of the library in the window.

use eframe::egui::{ColorImage, Image, Response, Sense, TextureHandle, TextureOptions, Ui, Vec2, load::SizedTexture};
use lobe::image::{Picture, Tone};

use crate::widgets::named::name_image;

/// A picture that is made again only when what it shows has changed.
#[derive(Default)]
pub(crate) struct PictureView {
    texture: Option<TextureHandle>,
    key: Vec<u64>,
}

impl PictureView {
    /// Shows a picture under a name at a size in points. It is made where `key` differs from that of the last time.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        name: &str,
        size: Vec2,
        key: Vec<u64>,
        make: impl FnOnce() -> (Picture, Tone),
    ) -> Response {
        if self.texture.is_none() || self.key != key {
            let (picture, tone) = make();
            let image = color_image(&picture, &tone);
            match &mut self.texture {
                Some(texture) => texture.set(image, TextureOptions::LINEAR),
                None => self.texture = Some(ui.ctx().load_texture(name, image, TextureOptions::LINEAR)),
            }
            self.key = key;
        }
        let Some(texture) = &self.texture else { return ui.label("no picture") };
        let image = Image::new(SizedTexture::new(texture.id(), size)).sense(Sense::click_and_drag());
        let response = ui.add(image);
        name_image(&response, name);
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
