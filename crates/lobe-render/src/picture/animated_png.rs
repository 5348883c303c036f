//! Pictures that move.

use std::io::Write;
use std::path::Path;

use lobe_io::write_atomically;

use crate::{Picture, RenderError, Tone};

/// An animated PNG file that is written picture by picture: pictures are shown one after the other, again and again.
///
/// Programs that know no animation show the first picture. Unlike GIF it keeps all colors: a sky has no bands. Nothing is kept
/// of a picture that was added.
///
/// ```
/// use lobe_render::{AnimatedPng, Picture, Tone};
/// use lobe_sh::Rgb;
///
/// let mut bytes = Vec::new();
/// let mut animation = AnimatedPng::new(&mut bytes, 4, 3, 10, 0.1)?;
/// for k in 0..10 {
///     animation.add(&Picture::filled(4, 3, Rgb::new(0.1, 0.1, 0.1 * k as f32)), &Tone::PLAIN)?;
/// }
/// animation.finish()?;
/// assert_eq!(&bytes[1..4], b"PNG");
/// # Ok::<(), lobe_render::RenderError>(())
/// ```
pub struct AnimatedPng<W: Write> {
    writer: png::Writer<W>,
    size: (usize, usize),
}

impl<W: Write> AnimatedPng<W> {
    /// Begins a file of so many pictures of one size, each shown so long.
    ///
    /// # Errors
    /// [`RenderError::Invalid`] if there are no pictures, no pixels or too many for the format; [`RenderError::Options`] if a
    /// picture would be shown for less than 1 ms or more than 65 s; [`RenderError::Output`] if `out` refuses.
    pub fn new(
        out: W,
        width: usize,
        height: usize,
        pictures: usize,
        seconds_per_picture: f64,
    ) -> Result<Self, RenderError> {
        let milliseconds = (1000.0 * seconds_per_picture).round();
        if !(1.0..=65_000.0).contains(&milliseconds) {
            let message = format!("expected 0.001 to 65 seconds a picture, found {seconds_per_picture}");
            return Err(RenderError::Options(message));
        }
        if pictures == 0 {
            return Err(RenderError::Invalid("an animation of no pictures".to_owned()));
        }
        let size = (width, height);
        let [Ok(columns), Ok(rows), Ok(count)] = [width, height, pictures].map(u32::try_from) else {
            return Err(invalid(size, "more than 2^32 columns, rows or pictures"));
        };
        let begin = || -> Result<png::Writer<W>, png::EncodingError> {
            let mut encoder = png::Encoder::new(out, columns, rows);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_depth(png::BitDepth::Eight);
            encoder.set_animated(count, 0)?;
            encoder.validate_sequence(true);
            encoder.set_frame_delay(milliseconds as u16, 1000)?;
            encoder.write_header()
        };
        Ok(Self { writer: begin().map_err(|error| refused(size, error))?, size })
    }

    /// The next picture. `tone` is applied to it by itself; [`Tone::fixed_for`] one of them keeps the light steady.
    ///
    /// # Errors
    /// [`RenderError::Invalid`] if it is of another size or one too many; [`RenderError::Output`] if the file refuses.
    pub fn add(&mut self, picture: &Picture, tone: &Tone) -> Result<(), RenderError> {
        let ((width, height), (w, h)) = (self.size, (picture.width(), picture.height()));
        if (w, h) != (width, height) {
            return Err(RenderError::Invalid(format!(
                "an animation of {width} x {height} with a picture of {w} x {h}"
            )));
        }
        self.writer.write_image_data(&tone.to_bytes(picture)).map_err(|error| refused(self.size, error))
    }

    /// Ends the file.
    ///
    /// # Errors
    /// [`RenderError::Invalid`] if pictures are missing; [`RenderError::Output`] if the file refuses.
    pub fn finish(self) -> Result<(), RenderError> {
        self.writer.finish().map_err(|error| refused(self.size, error))
    }
}

fn invalid((width, height): (usize, usize), what: &str) -> RenderError {
    RenderError::Invalid(format!("a {width} x {height} animation as PNG: {what}"))
}

fn refused(size: (usize, usize), error: png::EncodingError) -> RenderError {
    match error {
        png::EncodingError::IoError(source) => RenderError::Output(source),
        other => invalid(size, &other.to_string()),
    }
}

/// The bytes of an [`AnimatedPng`] of pictures that are all there.
///
/// # Errors
/// As [`AnimatedPng`].
pub fn animated_png(frames: &[Picture], tone: &Tone, seconds_per_frame: f64) -> Result<Vec<u8>, RenderError> {
    let (width, height) = frames.first().map_or((1, 1), |first| (first.width(), first.height()));
    let mut bytes = Vec::new();
    let mut animation = AnimatedPng::new(&mut bytes, width, height, frames.len(), seconds_per_frame)?;
    for frame in frames {
        animation.add(frame, tone)?;
    }
    animation.finish()?;
    Ok(bytes)
}

/// Writes [`animated_png`] as a file; nothing half-written ever has the final name.
///
/// # Errors
/// As [`animated_png`], and [`RenderError::Io`] if the file cannot be written.
pub fn write_animated_png(
    path: impl AsRef<Path>,
    frames: &[Picture],
    tone: &Tone,
    seconds_per_frame: f64,
) -> Result<(), RenderError> {
    let path = path.as_ref();
    let bytes = animated_png(frames, tone, seconds_per_frame)?;
    write_atomically(path, |file| file.write_all(&bytes))
        .map_err(|source| RenderError::Io { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use lobe_sh::{Coefficient as _, Rgb};

    use super::*;

    #[test]
    fn every_picture_is_in_the_file_in_its_turn() {
        let frames: Vec<_> = (0..3).map(|k| Picture::filled(5, 4, Rgb::splat(k as f32 / 2.0))).collect();
        let bytes = animated_png(&frames, &Tone::PLAIN, 0.04).unwrap();
        let mut reader = png::Decoder::new(Cursor::new(&bytes)).read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 3, "pictures");
        for expected in [0, 188, 255] {
            let mut shown = vec![0; 60];
            reader.next_frame(&mut shown).unwrap();
            assert!(shown.iter().all(|&b| b == expected), "expected {expected}, found {shown:?}");
            assert_eq!(reader.info().frame_control().unwrap().delay_num, 40, "milliseconds");
        }
    }

    #[test]
    fn what_is_no_animation_is_refused() {
        let (a, b) = (Picture::filled(2, 1, Rgb::ZERO), Picture::filled(1, 2, Rgb::ZERO));
        let refusal =
            |frames: &[Picture], seconds| animated_png(frames, &Tone::PLAIN, seconds).unwrap_err().to_string();
        assert_eq!(refusal(&[], 1.0), "an animation of no pictures", "none");
        assert_eq!(refusal(&[a.clone(), b], 1.0), "an animation of 2 x 1 with a picture of 1 x 2", "sizes");
        assert!(refusal(std::slice::from_ref(&a), 0.0).starts_with("expected 0.001 to 65 seconds"), "no time");
        let mut animation = AnimatedPng::new(Vec::new(), 2, 1, 2, 1.0).unwrap();
        animation.add(&a, &Tone::PLAIN).unwrap();
        let error = animation.finish().unwrap_err().to_string();
        assert!(error.starts_with("a 2 x 1 animation as PNG: "), "a picture is missing: {error}");
    }

    #[test]
    fn an_output_that_is_full_is_told() {
        struct Full(usize);
        impl Write for Full {
            fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
                self.0 = self.0.checked_sub(bytes.len()).ok_or(std::io::ErrorKind::StorageFull)?;
                Ok(bytes.len())
            }
            fn flush(&mut self) -> std::io::Result<()> {
                Ok(())
            }
        }
        let mut animation = AnimatedPng::new(Full(200), 64, 64, 9, 1.0).unwrap();
        let picture = Picture::from_fn(64, 64, |x, y| Rgb::splat((x * y % 7) as f32 / 7.0));
        let error = (0..9).find_map(|_| animation.add(&picture, &Tone::PLAIN).err());
        assert!(matches!(error, Some(RenderError::Output(_))), "{error:?}");
    }
}
