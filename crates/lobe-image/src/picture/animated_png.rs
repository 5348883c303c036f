//! Animated PNG files.

use std::io::Write;
use std::ops::RangeInclusive;
use std::path::Path;

use lobe_io::{StagedFile, StagedWriter};

use crate::error::ImageError;
use crate::picture::picture::Picture;
use crate::picture::png::{cannot_write, color_type, samples};
use crate::picture::tone::Tone;

/// A writer of an animated PNG file, picture by picture; the animation repeats forever.
///
/// Programs without animation show the first picture. Unlike GIF it keeps all colors: a sky has no bands. Added
/// pictures are not kept in memory.
///
/// ```
/// use lobe_image::{AnimatedPng, Picture, Tone};
///
/// let mut bytes = Vec::new();
/// let mut animation = AnimatedPng::new(&mut bytes, 4, 3, 10, 0.1)?;
/// for k in 0..10 {
///     animation.add(&Picture::filled(4, 3, [0.1, 0.1, 0.1 * k as f32]), &Tone::PLAIN)?;
/// }
/// animation.finish()?;
/// assert_eq!(&bytes[1..4], b"PNG");
/// # Ok::<(), lobe_image::ImageError>(())
/// ```
///
/// All pictures have an alpha, or none has.
pub struct AnimatedPng<W: Write> {
    /// Until the first picture, which decides whether there is an alpha.
    out: Option<W>,
    writer: Option<(png::Writer<W>, png::ColorType)>,
    size: (usize, usize),
    header: Header,
}

/// What the header says besides the channels.
struct Header {
    columns: u32,
    rows: u32,
    pictures: u32,
    /// Numerator and denominator, in seconds.
    delay: (u16, u16),
}

impl Header {
    fn write<W: Write>(&self, out: W, color: png::ColorType) -> Result<png::Writer<W>, png::EncodingError> {
        let mut encoder = png::Encoder::new(out, self.columns, self.rows);
        encoder.set_color(color);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_animated(self.pictures, 0)?;
        encoder.validate_sequence(true);
        encoder.set_frame_delay(self.delay.0, self.delay.1)?;
        encoder.write_header()
    }
}

impl<W: Write> AnimatedPng<W> {
    /// The seconds for which a picture can be shown.
    pub const SECONDS: RangeInclusive<f64> = 0.001..=65.0;

    /// Begins a file of `pictures` pictures of one size, each shown for `seconds_per_picture`.
    ///
    /// # Errors
    /// [`ImageError::Invalid`] if there are no pixels or too many for the format; [`ImageError::Options`] if there are
    /// no pictures, or one would be shown for less than 1 ms or more than 65 s.
    pub fn new(
        out: W,
        width: usize,
        height: usize,
        pictures: usize,
        seconds_per_picture: f64,
    ) -> Result<Self, ImageError> {
        let delay = delay(seconds_per_picture)?;
        if pictures == 0 {
            return Err(ImageError::Options("an animation of no pictures".to_owned()));
        }
        let size = (width, height);
        let [Ok(columns), Ok(rows), Ok(pictures)] = [width, height, pictures].map(u32::try_from) else {
            return Err(invalid(size, "more than 2^32 columns, rows or pictures"));
        };
        if columns == 0 || rows == 0 {
            return Err(invalid(size, "it has no pixels"));
        }
        Ok(Self { out: Some(out), writer: None, size, header: Header { columns, rows, pictures, delay } })
    }

    /// Adds the next picture. `tone` is applied to it by itself; [`Tone::fixed_for`] one of them keeps the exposure
    /// steady.
    ///
    /// # Errors
    /// [`ImageError::Options`] if it is of another size, or has an alpha unlike those before; [`ImageError::Invalid`]
    /// if it is one too many;
    /// [`ImageError::Io`] if the file refuses.
    pub fn add(&mut self, picture: &Picture, tone: &Tone) -> Result<(), ImageError> {
        let ((width, height), (w, h)) = (self.size, (picture.width(), picture.height()));
        if (w, h) != (width, height) {
            return Err(ImageError::Options(format!("an animation of {width} x {height} with a picture of {w} x {h}")));
        }
        let (color, size) = (color_type(picture), self.size);
        let (writer, begun) = self.begun(color)?;
        if *begun != color {
            return Err(ImageError::Options("an animation of pictures with alpha and without".to_owned()));
        }
        writer.write_image_data(&samples(picture, tone)).map_err(|error| refused(size, error))
    }

    /// The writer of pictures, which begins the file with those channels.
    fn begun(&mut self, color: png::ColorType) -> Result<&mut (png::Writer<W>, png::ColorType), ImageError> {
        if let Some(out) = self.out.take() {
            let writer = self.header.write(out, color).map_err(|error| refused(self.size, error))?;
            self.writer = Some((writer, color));
        }
        self.writer.as_mut().ok_or_else(|| invalid(self.size, "its file could not be begun"))
    }

    /// Ends the file.
    ///
    /// # Errors
    /// [`ImageError::Invalid`] if pictures are missing; [`ImageError::Io`] if the file refuses.
    pub fn finish(mut self) -> Result<(), ImageError> {
        self.begun(png::ColorType::Rgb)?;
        let size = self.size;
        self.writer.map_or(Ok(()), |(writer, _)| writer.finish().map_err(|error| refused(size, error)))
    }
}

/// The time of a picture as files have it, the nearest fraction of two numbers of sixteen bits: 1/60 of a second, and not 17/1000,
/// which is 2 % longer. It is off by less than one part in 30000.
pub(crate) fn delay(seconds: f64) -> Result<(u16, u16), ImageError> {
    let shown = AnimatedPng::<Vec<u8>>::SECONDS;
    if !shown.contains(&seconds) {
        let (least, most) = (shown.start(), shown.end());
        return Err(ImageError::Options(format!("expected {least} to {most} seconds a picture, found {seconds:?}")));
    }
    let (mut nearest, mut least_error) = ((1, 1), f64::INFINITY);
    for denominator in 1..=u16::MAX {
        let numerator = (seconds * f64::from(denominator)).round().max(1.0);
        let error = (numerator / f64::from(denominator) - seconds).abs();
        // Of equal fractions the shortest is the first.
        if numerator <= f64::from(u16::MAX) && error < least_error {
            (nearest, least_error) = ((numerator as u16, denominator), error);
        }
    }
    Ok(nearest)
}

fn invalid(size: (usize, usize), what: &str) -> ImageError {
    ImageError::Invalid { place: place(size), message: what.to_owned() }
}

/// The name of an animation, whose writer need not be a file.
fn place((width, height): (usize, usize)) -> String {
    format!("a {width} x {height} animation as PNG")
}

fn refused(size: (usize, usize), error: png::EncodingError) -> ImageError {
    match error {
        png::EncodingError::IoError(source) => ImageError::Io { place: place(size), source },
        other => invalid(size, &other.to_string()),
    }
}

/// The bytes of an [`AnimatedPng`] of the given pictures.
///
/// # Errors
/// As [`AnimatedPng`].
pub fn animated_png(frames: &[Picture], tone: &Tone, seconds_per_frame: f64) -> Result<Vec<u8>, ImageError> {
    let (width, height) = frames.first().map_or((1, 1), |first| (first.width(), first.height()));
    let mut bytes = Vec::new();
    let mut animation = AnimatedPng::new(&mut bytes, width, height, frames.len(), seconds_per_frame)?;
    for frame in frames {
        animation.add(frame, tone)?;
    }
    animation.finish()?;
    Ok(bytes)
}

/// Writes [`animated_png`] as a file; no partial file ever has the final name.
///
/// # Errors
/// As [`animated_png`], and [`ImageError::Io`] if the file cannot be written.
pub fn write_animated_png(
    path: impl AsRef<Path>,
    frames: &[Picture],
    tone: &Tone,
    seconds_per_frame: f64,
) -> Result<(), ImageError> {
    let (width, height) = frames.first().map_or((1, 1), |first| (first.width(), first.height()));
    write_animation(path.as_ref(), (width, height), frames.len(), seconds_per_frame, |add| {
        frames.iter().try_for_each(|frame| add(frame, tone))
    })
}

/// Takes the next picture and the tone mapping of its display.
pub type AddFrame<'a> = dyn FnMut(&Picture, &Tone) -> Result<(), ImageError> + 'a;

/// Writes an [`AnimatedPng`] as a file, to which `render` adds the pictures; one that it gives up is not there.
pub(crate) fn write_animation<E: From<ImageError>>(
    path: &Path,
    (width, height): (usize, usize),
    pictures: usize,
    seconds_per_picture: f64,
    render: impl FnOnce(&mut AddFrame<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let io = |error| cannot_write(path, &error);
    let in_file = |error| match error {
        ImageError::Io { source, .. } => cannot_write(path, &source),
        other => other,
    };
    let mut file = StagedWriter::new(path).map_err(io)?;
    let mut animation = AnimatedPng::new(&mut file, width, height, pictures, seconds_per_picture).map_err(in_file)?;
    render(&mut |picture, tone| animation.add(picture, tone).map_err(in_file))?;
    animation.finish().map_err(in_file)?;
    Ok(file.finish().and_then(StagedFile::publish).map_err(io)?)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    #[test]
    fn every_picture_is_in_the_file_in_its_turn() {
        let frames: Vec<_> = (0..3).map(|k| Picture::filled(5, 4, [k as f32 / 2.0; 3])).collect();
        let bytes = animated_png(&frames, &Tone::PLAIN, 0.04).unwrap();
        let mut reader = png::Decoder::new(Cursor::new(&bytes)).read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 3, "pictures");
        for expected in [0, 188, 255] {
            let mut shown = vec![0; 60];
            reader.next_frame(&mut shown).unwrap();
            assert!(shown.iter().all(|&b| b == expected), "expected {expected}, found {shown:?}");
            let control = reader.info().frame_control().unwrap();
            assert_eq!((control.delay_num, control.delay_den), (1, 25), "seconds");
        }
    }

    #[test]
    fn an_animation_runs_at_the_speed_that_was_asked_for() {
        for fps in [1_u16, 10, 24, 25, 30, 50, 60, 120, 1000] {
            assert_eq!(delay(f64::from(fps).recip()).unwrap(), (1, fps), "{fps} a second");
        }
        // Film on television, by its name and as it is.
        assert_eq!(delay(1.0 / 23.976).unwrap(), (125, 2997), "23.976 a second");
        assert_eq!(delay(1001.0 / 24000.0).unwrap(), (1001, 24000), "24000/1001 a second");
        for (seconds, expected) in [(0.04, (1, 25)), (1.5, (3, 2)), (12.34, (617, 50)), (65.0, (65, 1))] {
            assert_eq!(delay(seconds).unwrap(), expected, "{seconds} s");
        }
        let (least, most) = AnimatedPng::<Vec<u8>>::SECONDS.into_inner();
        for k in 0..100 {
            let seconds = (least * (most / least).powf(f64::from(k) / 99.0)).min(most);
            let (numerator, denominator) = delay(seconds).unwrap();
            let error = f64::from(numerator) / f64::from(denominator) / seconds - 1.0;
            assert!(error.abs() < 1.0 / 30000.0, "{seconds} s: {numerator}/{denominator}, off by {error}");
        }
    }

    #[test]
    fn pictures_of_an_animation_have_an_alpha_all_or_none() {
        let clear = Picture::filled(2, 1, [0.5; 3]).with_alpha(vec![1.0, 0.5]).unwrap();
        let bytes = animated_png(&[clear.clone(), clear.clone()], &Tone::PLAIN, 1.0).unwrap();
        let mut reader = png::Decoder::new(Cursor::new(&bytes)).read_info().unwrap();
        for _ in 0..2 {
            let mut shown = vec![0; 8];
            reader.next_frame(&mut shown).unwrap();
            assert_eq!(shown, [188, 188, 188, 255, 255, 255, 255, 128], "straight color and alpha");
        }
        let error = animated_png(&[clear, Picture::filled(2, 1, [0.5; 3])], &Tone::PLAIN, 1.0).unwrap_err().to_string();
        assert_eq!(error, "an animation of pictures with alpha and without", "{error}");
    }

    #[test]
    fn what_is_no_animation_is_refused() {
        let (a, b) = (Picture::filled(2, 1, [0.0; 3]), Picture::filled(1, 2, [0.0; 3]));
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
        let picture = Picture::from_fn(64, 64, |x, y| [(x * y % 7) as f32 / 7.0; 3]);
        let error = (0..9).find_map(|_| animation.add(&picture, &Tone::PLAIN).err());
        assert!(matches!(error, Some(ImageError::Io { .. })), "{error:?}");
    }
}
