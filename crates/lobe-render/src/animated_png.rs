//! Pictures that move.

use std::path::Path;

use lobe_sh::write_atomically;

use crate::{Picture, RenderError, Tone};

/// The bytes of an animated PNG file that shows pictures one after the other, again and again.
///
/// Programs that know no animation show the first picture. Unlike GIF it keeps all colours: a sky has no bands.
///
/// `tone` is applied to each picture by itself; [`Tone::fixed_for`] one of them keeps the light steady.
///
/// # Errors
/// [`RenderError::Invalid`] if there are no pictures, they differ in size, have no pixels or too many for the format;
/// [`RenderError::Options`] if a picture would be shown for less than 1 ms or more than 65 s.
pub fn animated_png(frames: &[Picture], tone: &Tone, seconds_per_frame: f64) -> Result<Vec<u8>, RenderError> {
    let milliseconds = (1000.0 * seconds_per_frame).round();
    if !(1.0..=65_000.0).contains(&milliseconds) {
        return Err(RenderError::Options(format!("expected 0.001 to 65 seconds a picture, found {seconds_per_frame}")));
    }
    let Some(first) = frames.first() else {
        return Err(RenderError::Invalid("an animation of no pictures".to_owned()));
    };
    let (width, height) = (first.width(), first.height());
    if let Some(other) = frames.iter().find(|frame| (frame.width(), frame.height()) != (width, height)) {
        let (w, h) = (other.width(), other.height());
        return Err(RenderError::Invalid(format!("an animation of {width} x {height} with a picture of {w} x {h}")));
    }
    let invalid = |what: &str| RenderError::Invalid(format!("a {width} x {height} animation as PNG: {what}"));
    let (Ok(columns), Ok(rows), Ok(count)) = (u32::try_from(width), u32::try_from(height), u32::try_from(frames.len()))
    else {
        return Err(invalid("more than 2^32 columns, rows or pictures"));
    };
    let mut bytes = Vec::new();
    let encode = |bytes: &mut Vec<u8>| -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(bytes, columns, rows);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_animated(count, 0)?;
        encoder.set_frame_delay(milliseconds as u16, 1000)?;
        let mut writer = encoder.write_header()?;
        for frame in frames {
            writer.write_image_data(&tone.to_bytes(frame))?;
        }
        writer.finish()
    };
    encode(&mut bytes).map_err(|error| invalid(&error.to_string()))?;
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
        assert!(refusal(&[a], 0.0).starts_with("expected 0.001 to 65 seconds"), "no time");
    }
}
