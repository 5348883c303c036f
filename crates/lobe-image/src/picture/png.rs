//! PNG writer.

use std::io;
use std::path::Path;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use lobe_io::write_atomically;
use png::{ColorType, Compression, Filter};

use crate::error::ImageError;
use crate::picture::picture::Picture;
use crate::picture::tone::Tone;

/// The name under which a picture keeps the name of its mapping: of a text of PNG, of an attribute of OpenEXR, of a line
/// of the header of Radiance.
pub(crate) const MAPPING_KEY: &str = "lobe-mapping";

impl Picture {
    /// The bytes of the picture as an 8-bit sRGB PNG file, with its alpha if it has one: see
    /// [`Tone::to_rgba_bytes`].
    ///
    /// # Errors
    /// [`ImageError::Invalid`] if the picture is empty or too large for the format.
    pub fn to_png(&self, tone: &Tone) -> Result<Vec<u8>, ImageError> {
        self.to_png_with(tone, None)
    }

    /// The bytes of the picture as an 8-bit sRGB PNG file that keeps the name of a mapping, see
    /// [`PictureWriteOptions::mapping`](crate::PictureWriteOptions).
    ///
    /// # Errors
    /// As [`to_png`](Picture::to_png), and if the name is no Latin-1 text.
    pub fn to_png_with(&self, tone: &Tone, mapping: Option<&str>) -> Result<Vec<u8>, ImageError> {
        let (width, height) = (self.width(), self.height());
        let invalid = |what: &str| ImageError::Invalid {
            place: format!("a {width} x {height} picture as PNG"),
            message: what.to_owned(),
        };
        let (Ok(columns), Ok(rows)) = (u32::try_from(width), u32::try_from(height)) else {
            return Err(invalid("more than 2^32 columns or rows"));
        };
        if columns == 0 || rows == 0 {
            return Err(invalid("it has no pixels"));
        }
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, columns, rows);
        encoder.set_color(color_type(self));
        encoder.set_compression(Compression::Balanced);
        encoder.set_filter(Filter::Adaptive);
        let write = || -> Result<(), png::EncodingError> {
            if let Some(mapping) = mapping {
                encoder.add_text_chunk(MAPPING_KEY.to_owned(), mapping.to_owned())?;
            }
            encoder.write_header()?.write_image_data(&samples(self, tone))
        };
        write().map_err(|error| invalid(&error.to_string()))?;
        Ok(bytes)
    }

    /// An SVG document that shows the picture, as PNG inside of it: for pages that take only SVG.
    ///
    /// # Errors
    /// As [`to_png`](Picture::to_png).
    pub fn to_svg(&self, tone: &Tone) -> Result<String, ImageError> {
        let (width, height, png) = (self.width(), self.height(), BASE64_STANDARD.encode(self.to_png(tone)?));
        Ok(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\">\n\
             <image width=\"{width}\" height=\"{height}\" href=\"data:image/png;base64,{png}\"/>\n</svg>\n"
        ))
    }

    /// Writes the picture as an 8-bit sRGB PNG file; no partial file ever has the final name.
    ///
    /// # Errors
    /// As [`Picture::to_png`], and [`ImageError::Io`] if the file cannot be written.
    pub fn write_png(&self, path: impl AsRef<Path>, tone: &Tone) -> Result<(), ImageError> {
        let path = path.as_ref();
        let png = self.to_png(tone)?;
        write_atomically(path, |file| file.write_all(&png)).map_err(|error| cannot_write(path, &error))
    }
}

/// The channels of the pixels of a picture.
pub(crate) fn color_type(picture: &Picture) -> ColorType {
    if picture.alpha().is_some() { ColorType::Rgba } else { ColorType::Rgb }
}

/// The bytes of the pixels of a picture.
pub(crate) fn samples(picture: &Picture, tone: &Tone) -> Vec<u8> {
    if picture.alpha().is_some() { tone.to_rgba_bytes(picture) } else { tone.to_bytes(picture) }
}

/// The error of a file that cannot be written.
pub(crate) fn cannot_write(path: &Path, error: &io::Error) -> ImageError {
    let source = io::Error::new(error.kind(), format!("cannot write the picture: {error}"));
    ImageError::Io { place: path.display().to_string(), source }
}
