//! Pictures as outputs: kinds of files, and notes on values that they cannot hold.

use std::path::PathBuf;
use std::str::FromStr;

use lobe::env::{MappedMap, write_env};
use lobe::image::{FileFormat, ImageError, Picture, PictureWriteOptions, PictureWriteReport, Tone, write_picture};
use lobe::io::write_atomically;

use crate::args::input::texels_are;
use crate::args::output;
use crate::run::talk::Talk;

/// A file to write a picture to; its extension decides its kind.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PictureOutput {
    path: PathBuf,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Radiance, OpenEXR or PFM: the values.
    Light,
    /// PNG: for looking at.
    Display,
}

impl FromStr for PictureOutput {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let path = PathBuf::from(text);
        let kind = match FileFormat::of_name(&path) {
            Some(FileFormat::Png) => Kind::Display,
            Some(format) if format.is_written() => Kind::Light,
            _ => return Err(format!("expected a name that ends in {}", Self::endings())),
        };
        Ok(Self { path, kind })
    }
}

impl PictureOutput {
    /// The endings of its names.
    pub(crate) fn endings() -> String {
        FileFormat::names(|format| format.is_written() || format == FileFormat::Png)
    }

    /// Help of an option that names the file of this picture.
    pub(crate) fn help(picture: &str) -> String {
        format!("{picture}: {}; a .png is tone-mapped for looking at", Self::endings())
    }

    /// Whether it can be of half floats.
    pub(crate) fn is_exr(&self) -> bool {
        output::has_extension(&self.path, "exr")
    }

    /// Whether it holds the values, and not what they look like.
    pub(crate) fn is_light(&self) -> bool {
        self.kind == Kind::Light
    }

    /// Refuses an output that could not be written or is an input, before any work is done for it.
    pub(crate) fn check(&self, inputs: &[PathBuf]) -> anyhow::Result<()> {
        output::prepare_file(&self.path, inputs)
    }

    /// Writes a map, and notes the values that the format could not hold.
    pub(crate) fn write_map(&self, map: &MappedMap, options: &PictureWriteOptions, talk: Talk) -> anyhow::Result<()> {
        match self.kind {
            Kind::Light => {
                let report = talk.while_waiting("write", || write_env(&self.path, map, options))?;
                note_clamped(&self.name(), report, talk);
            }
            Kind::Display => {
                let picture = Picture::new(map.width(), map.height(), map.texels().to_vec())?;
                self.write_png(&picture, map.untold_mapping(), talk)?;
            }
        }
        Ok(())
    }

    /// Writes a picture in which directions are laid out as the options say, if at all, and notes the values that the format could not hold.
    pub(crate) fn write(&self, picture: &Picture, options: &PictureWriteOptions, talk: Talk) -> anyhow::Result<()> {
        match self.kind {
            Kind::Light => note_clamped(&self.name(), write_picture(&self.path, picture, options)?, talk),
            Kind::Display => self.write_png(picture, options.mapping.as_deref(), talk)?,
        }
        Ok(())
    }

    fn write_png(&self, picture: &Picture, mapping: Option<&str>, talk: Talk) -> anyhow::Result<()> {
        let (curve, stops) = (Tone::PHOTOGRAPH.curve, Tone::PHOTOGRAPH.exposure.factor(picture).log2());
        let png = picture.to_png_with(&Tone::PHOTOGRAPH, mapping)?;
        write_atomically(&self.path, |w| w.write_all(&png))
            .map_err(|source| ImageError::Io { place: self.name(), source })?;
        talk.note(&self.name(), &format!("tone-mapped by {curve}, exposure {stops:.2} stops; .exr holds the values"));
        Ok(())
    }

    /// The name for messages.
    pub(crate) fn name(&self) -> String {
        self.path.display().to_string()
    }
}

/// A share in percent, of two digits.
pub(crate) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent < 0.01 { "less than 0.01 %".to_owned() } else { format!("{percent:.2} %") }
}

/// Notes the number of texels that a format could not hold as they were, and which one does.
pub(crate) fn note_clamped(name: &str, report: PictureWriteReport, talk: Talk) {
    let instead = match name.rsplit_once('.').map(|(_, extension)| extension.to_ascii_lowercase()).as_deref() {
        Some("exr") => "without --half it holds all",
        Some("ktx2" | "dds") => "--texels rgba32f holds all",
        Some("ktx") => ".ktx2 with --texels rgba32f holds all",
        _ => ".exr holds all",
    };
    let sun = if report.lost > 0.0 { ", and lobe env sun takes a sun out" } else { "" };
    note_moved(name, report, &format!("; {instead}{sun}"), talk);
}

/// Notes the number of texels that a format could not hold as they were, where there is no other.
pub(crate) fn note_moved(name: &str, report: PictureWriteReport, instead: &str, talk: Talk) {
    if report.clamped > 0 {
        let texels = texels_are(report.clamped);
        let lost = if report.lost > 0.0 {
            format!(", which loses {} of the light", percent(report.lost))
        } else {
            String::new()
        };
        talk.note(name, &format!("{texels} outside of what this format holds and moved into it{lost}{instead}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_says_what_is_written() {
        for (name, kind) in [
            ("a.exr", Some(Kind::Light)),
            ("A.HDR", Some(Kind::Light)),
            ("b.pfm", Some(Kind::Light)),
            ("folder.png/c.png", Some(Kind::Display)),
            ("d.jpg", None),
            ("-", None),
            ("png", None),
            (".png", None),
        ] {
            let found = name.parse::<PictureOutput>();
            assert_eq!(found.as_ref().ok().map(|output| output.kind), kind, "{name}: {found:?}");
        }
    }
}
