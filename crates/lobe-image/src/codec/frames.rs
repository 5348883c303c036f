//! Pictures one after another as files.

use std::path::{Path, PathBuf};

use lobe_io::check_writable;

use crate::codec::encode::PictureWriteOptions;
use crate::codec::encode::write_picture;
use crate::codec::file_format::FileFormat;
use crate::error::ImageError;
use crate::picture::animated_png::AddFrame;
use crate::picture::animated_png::{delay, write_animation};
use crate::picture::png::cannot_write;

/// What pictures that come one after another are.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FrameSequence {
    /// Columns of each, as an animation has to know before the first.
    pub width: usize,
    /// Rows of each, likewise.
    pub height: usize,
    /// How many there are.
    pub frames: usize,
    /// Seconds for which an animation shows each, 0.001 to 65.
    pub seconds_per_frame: f64,
}

impl FrameSequence {
    /// The file of picture `frame` of several, `name.0007.exr` of `name.exr`; the path itself of one picture, and of an animation,
    /// which holds all.
    #[must_use]
    pub fn path(&self, path: impl AsRef<Path>, frame: usize) -> PathBuf {
        let path = path.as_ref();
        if self.frames == 1 || is_png(path) {
            return path.to_owned();
        }
        let ending = path.extension().map(|ending| ending.to_string_lossy().into_owned()).unwrap_or_default();
        path.with_extension(format!("{frame:04}.{ending}"))
    }

    /// Whether [`FrameSequence::write`] could begin to write, to be asked before long work. Changes nothing.
    ///
    /// # Errors
    /// [`ImageError::Options`] for another ending than .png, .exr, .hdr or .pfm, or an animation whose pictures are shown for too short
    /// or too long; [`ImageError::Io`] if the folder refuses.
    pub fn check(&self, path: impl AsRef<Path>) -> Result<(), ImageError> {
        let path = path.as_ref();
        if !is_png(path) && !FileFormat::of_name(path).is_some_and(FileFormat::is_written) {
            let written = FileFormat::names(|format| format.is_written() || format == FileFormat::Png);
            let message = format!("{}: pictures are written as {written}", path.display());
            return Err(ImageError::Options(message));
        }
        if self.is_animation(path) {
            delay(self.seconds_per_frame)?;
        }
        check_writable(&self.path(path, 0)).map_err(|error| cannot_write(path, &error))
    }

    /// Writes pictures as they come: `render` hands each, in linear light with the tone mapping of its display, to the function
    /// that it is given. Several are an animated PNG where the path ends so, and else files by [`FrameSequence::path`]. None is
    /// kept in memory, and no partial file ever has its final name; an animation that `render` gives up is not there.
    ///
    /// # Errors
    /// What `render` returns; [`ImageError`] if a file cannot be written, as [`AnimatedPng`](crate::AnimatedPng) and [`write_picture`], or
    /// there were more or fewer pictures.
    pub fn write<E: From<ImageError>>(
        &self,
        path: impl AsRef<Path>,
        render: impl FnOnce(&mut AddFrame<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let path = path.as_ref();
        if self.is_animation(path) {
            return self.animate(path, render);
        }
        let mut number = 0;
        render(&mut |picture, tone| {
            let file = self.path(path, number);
            number += 1;
            if is_png(path) {
                return picture.write_png(&file, tone);
            }
            write_picture(&file, picture, &PictureWriteOptions::default()).map(drop)
        })?;
        if number != self.frames {
            let message = format!("{}: expected {} pictures, found {number}", path.display(), self.frames);
            return Err(ImageError::Options(message).into());
        }
        Ok(())
    }

    /// The same as an animated PNG, of one picture too.
    ///
    /// # Errors
    /// As [`FrameSequence::write`].
    pub fn animate<E: From<ImageError>>(
        &self,
        path: impl AsRef<Path>,
        render: impl FnOnce(&mut AddFrame<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        write_animation(path.as_ref(), (self.width, self.height), self.frames, self.seconds_per_frame, render)
    }

    fn is_animation(&self, path: &Path) -> bool {
        is_png(path) && self.frames > 1
    }
}

fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::read::{PictureReadOptions, read_picture};
    use crate::picture::animated_png::animated_png;
    use crate::picture::picture::Picture;
    use crate::picture::tone::Tone;

    const SEQUENCE: FrameSequence = FrameSequence { width: 5, height: 4, frames: 3, seconds_per_frame: 0.04 };

    fn gray(k: usize) -> Picture {
        Picture::filled(5, 4, [k as f32 / 2.0; 3])
    }

    fn read(path: &Path) -> Picture {
        read_picture(path, &PictureReadOptions::default()).unwrap().0
    }

    fn all(add: &mut AddFrame<'_>) -> Result<(), ImageError> {
        (0..SEQUENCE.frames).try_for_each(|k| add(&gray(k), &Tone::PLAIN))
    }

    #[test]
    fn an_animation_of_pictures_as_they_come_has_the_bytes_of_one_of_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("turn.png");
        SEQUENCE.write(&path, all).unwrap();
        let frames: Vec<_> = (0..3).map(gray).collect();
        assert_eq!(std::fs::read(&path).unwrap(), animated_png(&frames, &Tone::PLAIN, 0.04).unwrap(), "bytes");
    }

    #[test]
    fn what_cannot_be_written_is_known_before() {
        let folder = tempfile::tempdir().unwrap();
        let check = |name: &str| SEQUENCE.check(folder.path().join(name)).map_err(|error| error.to_string());
        for name in ["a.png", "a.PNG", "a.exr", "a.hdr", "a.pfm"] {
            check(name).unwrap();
        }
        assert!(
            check("a.gif").unwrap_err().ends_with("a.gif: pictures are written as .exr, .hdr, .pfm or .png"),
            "ending"
        );
        let for_ever = FrameSequence { seconds_per_frame: 66.0, ..SEQUENCE };
        let line = for_ever.check(folder.path().join("a.png")).unwrap_err().to_string();
        assert!(line.starts_with("expected 0.001 to 65 seconds"), "{line}");
        for_ever.check(folder.path().join("a.exr")).unwrap();
        assert!(check("none/a.png").unwrap_err().contains("cannot write the picture"), "no folder");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is written");
    }

    #[test]
    fn other_kinds_are_numbered_and_one_picture_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("turn.exr");
        SEQUENCE.write(&path, all).unwrap();
        for k in 0..3 {
            let file = folder.path().join(format!("turn.000{k}.exr"));
            assert_eq!(read(&file), gray(k), "picture {k}");
        }
        let few = SEQUENCE.write(&path, |add| add(&gray(0), &Tone::PLAIN)).unwrap_err().to_string();
        assert!(few.ends_with("expected 3 pictures, found 1"), "{few}");
        let one = FrameSequence { frames: 1, ..SEQUENCE };
        one.write(&path, |add| add(&gray(1), &Tone::PLAIN)).unwrap();
        assert_eq!(read(&path), gray(1), "one");
    }

    #[test]
    fn an_animation_that_was_given_up_leaves_the_file_that_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("turn.png");
        std::fs::write(&path, "before").unwrap();
        let given_up = || ImageError::Options("given up".to_owned());
        let error = SEQUENCE.write(&path, |add| add(&gray(0), &Tone::PLAIN).and_then(|()| Err(given_up())));
        assert_eq!(error.unwrap_err().to_string(), given_up().to_string(), "what was returned");
        let missing = SEQUENCE.write(&path, |add| add(&gray(0), &Tone::PLAIN)).unwrap_err().to_string();
        assert!(missing.starts_with("a 5 x 4 animation as PNG: "), "pictures are missing: {missing}");
        assert_eq!(std::fs::read(&path).unwrap(), b"before", "the file");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "and nothing beside it");
    }
}
