//! The pictures that `lobe render` writes: one, or those of a turn of the light and their animation.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use lobe::image::{Exposure, Picture, PictureWriteOptions, Tone, write_picture};
use lobe::io::{JobArgs, flag};
use lobe::render::{LitPicture, ToneOptions, Truth};

use crate::args::output::{self, has_extension};
use crate::args::picture::note_clamped;
use crate::args::values;
use crate::run::talk::Talk;

/// The most pictures. A larger number is taken for a typing error.
const MAX_FRAMES: usize = 1000;

/// Files to write pictures to.
#[derive(Args)]
pub(crate) struct Pictures {
    /// The picture: .png tone-mapped for looking at, .exr with the values; of the truth with variance, albedo, normal, depth and
    /// coverage
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    tone: JobArgs<ToneOptions>,
    /// N: turn the light once around in N pictures, OUT-000.png (or .exr) and on, and all of them as an animation in OUT.png;
    /// what moves stands still. A..B: let a scene move through pictures A to B, both included, of which 0 is at time 0
    #[arg(long, value_name = "N|A..B", value_parser = frames)]
    frames: Option<FrameNumbers>,
}

/// The pictures of `--frames`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FrameNumbers {
    /// As many of a turn of the light.
    Turn(usize),
    /// From the first to the last, of a scene that moves.
    Range(usize, usize),
}

/// The last number of a picture. A larger one is taken for a typing error.
const MAX_FRAME: usize = 1_000_000;

fn frames(text: &str) -> Result<FrameNumbers, String> {
    let Some((first, last)) = text.split_once("..") else {
        return values::whole(text, 2, MAX_FRAMES, "a number of pictures").map(FrameNumbers::Turn);
    };
    let number = |text: &str| values::whole(text, 0, MAX_FRAME, "a number of a picture");
    match (number(first)?, number(last)?) {
        (first, last) if first <= last && last - first < MAX_FRAMES => Ok(FrameNumbers::Range(first, last)),
        (first, last) => Err(format!("expected 1 to {MAX_FRAMES} pictures in order, found {first} to {last}")),
    }
}

/// A picture, with all its channels if it was traced.
pub(crate) enum Rendered {
    Traced(Box<Truth>),
    Shaded(LitPicture),
}

impl Rendered {
    pub(crate) fn picture(&self) -> &Picture {
        match self {
            Self::Traced(truth) => &truth.mean,
            Self::Shaded(shaded) => &shaded.picture,
        }
    }
}

impl Pictures {
    pub(crate) fn count(&self) -> usize {
        match self.frames {
            None => 1,
            Some(FrameNumbers::Turn(count)) => count,
            Some(FrameNumbers::Range(first, last)) => last - first + 1,
        }
    }

    /// Whether there are numbers of pictures of a scene that moves.
    pub(crate) fn is_range(&self) -> bool {
        matches!(self.frames, Some(FrameNumbers::Range(..)))
    }

    /// The number of picture `k` in the scene that moves.
    pub(crate) fn frame(&self, k: usize) -> Option<usize> {
        match self.frames {
            Some(FrameNumbers::Range(first, _)) => Some(first + k),
            _ => None,
        }
    }

    pub(crate) fn name(&self) -> String {
        self.output.display().to_string()
    }

    /// The output as it was given.
    pub(crate) fn output(&self) -> &Path {
        &self.output
    }

    /// Whether the light turns.
    pub(crate) fn is_turn(&self) -> bool {
        matches!(self.frames, Some(FrameNumbers::Turn(_)))
    }

    /// The path of picture `k`.
    pub(crate) fn path(&self, k: usize) -> PathBuf {
        if self.frames.is_none() {
            return self.output.clone();
        }
        let stem = self.output.file_stem().unwrap_or_default().to_string_lossy();
        let extension = if self.is_png() { "png" } else { "exr" };
        let number = self.frame(k).unwrap_or(k);
        self.output.with_file_name(format!("{stem}-{number:03}.{extension}"))
    }

    pub(crate) fn animation_path(&self) -> Option<PathBuf> {
        self.frames.map(|_| self.output.with_extension("png"))
    }

    /// Refuses names that cannot be written, and those of inputs.
    pub(crate) fn check(&self, inputs: &[&Path]) -> anyhow::Result<()> {
        self.tone.job()?;
        let is_display = self.is_png() || self.frames.is_some();
        if let Some(option) = self.tone.values.keys().next().filter(|_| !is_display) {
            let option = flag(option);
            bail!("{option}: only of .png pictures; leave the option out");
        }
        if !self.is_png() && !has_extension(&self.output, "exr") {
            bail!("-o: expected a name that ends in .png or .exr, found {}", self.name());
        }
        for path in (0..self.count()).map(|k| self.path(k)).chain(self.animation_path()) {
            output::prepare_file(&path, inputs)?;
        }
        Ok(())
    }

    /// The tone curve of all pictures, given the first one.
    pub(crate) fn tone(&self, first: &Picture) -> anyhow::Result<Tone> {
        Ok(self.tone.job()?.of_first(first))
    }

    /// Writes picture `k`.
    pub(crate) fn write(&self, rendered: &Rendered, tone: &Tone, k: usize, talk: Talk) -> anyhow::Result<()> {
        let path = self.path(k);
        let name = path.display().to_string();
        if self.is_png() {
            rendered.picture().write_png(&path, tone)?;
            if let (0, Exposure::Fixed(factor)) = (k, tone.exposure) {
                let (curve, stops) = (tone.curve, factor.log2());
                talk.note(&name, &format!("tone-mapped by {curve}, exposure {stops:.2} stops; .exr holds the values"));
            }
            return Ok(());
        }
        match rendered {
            Rendered::Traced(truth) => truth.write_exr(&path)?,
            Rendered::Shaded(LitPicture { picture, .. }) => {
                note_clamped(&name, write_picture(&path, picture, &PictureWriteOptions::default())?, talk);
            }
        }
        Ok(())
    }

    pub(crate) fn is_png(&self) -> bool {
        has_extension(&self.output, "png")
    }
}
