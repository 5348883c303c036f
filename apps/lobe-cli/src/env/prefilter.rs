//! `lobe env prefilter`: maps prefiltered for glossy reflection, by GGX or Phong lobes.

use std::str::FromStr;

use anyhow::bail;
use clap::Args;
use lobe::env::{
    CubeMap, MappedMap, Mapping, PrefilterOptions, RoughnessLevels, SpecularLobe, cube_source, filter_lobe,
    prefilter_ggx, project_map,
};
use lobe::image::FileFormat;

use crate::args::map_input::{MapInput, OF_LARGER};
use crate::args::map_output::MapOutput;
use crate::args::names::names;
use crate::args::values;
use crate::run::talk::Talk;

/// Bytes for each texel of the map, which becomes a cube and a tree over that, as measured.
pub(crate) const OF_SOURCE: u64 = 40;

/// Bytes for each texel of the first level of a chain that is written as lat-long pictures: the chain, and a picture of
/// eight texels for six while it is made.
const OF_LEVELS: u64 = 16 + OF_LARGER * 8 / 6;

/// Bands of the light beside a chain: nine colors.
const LIGHT_ORDER: usize = 3;

#[derive(Args)]
pub(crate) struct EnvPrefilter {
    #[command(flatten)]
    input: MapInput,
    #[command(flatten)]
    output: MapOutput,
    /// ggx: a chain of levels from the mirror to roughness 1, as .ktx2, .dds or .ktx, or as FOLDER/PREFIX%.exr (or .hdr, .pfm)
    /// with one lat-long picture for each level, numbered from 0; phong:E and blinn-phong:E: a
    /// highlight map for this exponent, any kind of file. All are divided by their weights: an even map stays as it is
    #[arg(long, value_name = "ggx|phong:E|blinn-phong:E", default_value = "ggx")]
    lobe: Lobe,
    /// The size of a face, of a chain that of the first level, 1 to 8192
    #[arg(long, value_name = "N", default_value = "256", value_parser = values::rows)]
    size: usize,
    /// With ggx: the size of the last level [default: 16, or --size if that is smaller; 1 with --roughness babylon,
    /// unity and unreal]
    #[arg(long, value_name = "N", value_parser = values::rows)]
    last_size: Option<usize>,
    /// With ggx: which level holds which roughness r; alpha = r² [default: quadratic in .ktx, which Filament reads;
    /// else linear]
    #[arg(long, value_enum)]
    roughness: Option<Roughness>,
    /// The error that is allowed, relative to the peak that a single small light makes, 1e-6 to 0.1
    /// [default: 0.02, which is seldom more than 0.002 off, beside lamps too]
    #[arg(long, value_name = "X", value_parser = values::positive)]
    tolerance: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Lobe {
    Ggx,
    Phong(f64),
    BlinnPhong(f64),
}

impl FromStr for Lobe {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let exponent = |text: &str| match values::finite(text)? {
            e if e >= 0.0 => Ok(e),
            e => Err(format!("an exponent is 0 or more, not {e}")),
        };
        match text.split_once(':') {
            None if text == "ggx" => Ok(Self::Ggx),
            Some(("phong", e)) => Ok(Self::Phong(exponent(e)?)),
            Some(("blinn-phong", e)) => Ok(Self::BlinnPhong(exponent(e)?)),
            _ => Err("expected ggx, phong:E or blinn-phong:E".to_owned()),
        }
    }
}

names! {
    /// The roughness of each level.
    enum Roughness for RoughnessLevels {
        /// r = level / last level: the glTF sample viewer, bevy
        Linear,
        /// level = last level · r (2 - r), more levels for smooth surfaces: Filament, three.js
        Quadratic,
        /// Babylon.js: alpha = 2^(level / 0.8) / size
        Babylon,
        /// Unity: level = 6 r (1.7 - 0.7 r)
        Unity,
        /// Unreal Engine: level = last level - 2 + 1.2 log2 r
        Unreal,
    }
}

impl EnvPrefilter {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.check_options()?;
        self.output.check(Mapping::Cube, &self.input.files()?)?;
        let map: MappedMap = self.input.read(talk)?;
        self.check_memory(&map)?;
        let light = self.output.keeps_light().then(|| project_map(&map, LIGHT_ORDER));
        let source = talk.watch("convert", |job| cube_source(map, self.size, job))?;
        match self.lobe {
            Lobe::Ggx => {
                let options = self.chain_options();
                let chain = talk.watch("prefilter", |job| prefilter_ggx(&source, &options, job))?;
                let roughness = |k| options.roughness.roughness_of_level(k, options.levels());
                let level = |k| format!("roughness {:.4}, alpha {:.4}", roughness(k), options.alpha_of_level(k));
                self.output.write_levels(&chain, light.as_ref(), level, talk)
            }
            Lobe::Phong(exponent) => self.write_highlights(&source, SpecularLobe::Phong { exponent }, talk),
            Lobe::BlinnPhong(exponent) => self.write_highlights(&source, SpecularLobe::BlinnPhong { exponent }, talk),
        }
    }

    /// Refuses options that would be ignored.
    fn check_options(&self) -> anyhow::Result<()> {
        let is_chain = self.lobe == Lobe::Ggx;
        let ignored = [
            (self.last_size.is_some() && !is_chain, "--last-size: only of the chain of --lobe ggx"),
            (self.roughness.is_some() && !is_chain, "--roughness: only of the chain of --lobe ggx"),
            (
                is_chain && self.output.makes_levels(),
                "--mips: the levels of the chain of --lobe ggx are its own; leave it out",
            ),
            (
                is_chain && !self.output.holds_levels(),
                &*format!(
                    "-o: the chain of --lobe ggx is written as {}, or by a name with % as {}, one for each level",
                    FileFormat::names(FileFormat::is_texture),
                    FileFormat::names(FileFormat::is_written)
                ),
            ),
        ];
        match ignored.into_iter().find(|(is_ignored, _)| *is_ignored) {
            Some((_, message)) => bail!("{message}"),
            None => Ok(()),
        }
    }

    /// Refuses work that takes more memory than allowed.
    fn check_memory(&self, map: &MappedMap) -> anyhow::Result<()> {
        let (width, height, size) = (map.width() as u64, map.height() as u64, self.size as u64);
        let of_pictures = self.lobe == Lobe::Ggx && !self.output.is_texture();
        let of_result = if of_pictures { OF_LEVELS } else { self.output.bytes_of_texel(Mapping::Cube) };
        let bytes = OF_SOURCE * width * height + of_result * 6 * size * size;
        let what = format!("faces of {size} x {size} texels from a map of {width} x {height}");
        self.input.memory().check(&what, bytes, "a smaller --size, or a smaller map")
    }

    fn chain_options(&self) -> PrefilterOptions {
        let mut options = PrefilterOptions::default();
        options.size = self.size;
        options.roughness = self.roughness.map_or(self.output.usual_roughness(), RoughnessLevels::from);
        options.last_size = self.last_size.unwrap_or(options.roughness.usual_last_size(self.size));
        options.tolerance = self.tolerance.unwrap_or(options.tolerance);
        options
    }

    fn write_highlights(&self, source: &CubeMap, lobe: SpecularLobe, talk: Talk) -> anyhow::Result<()> {
        let tolerance = self.chain_options().tolerance;
        let filtered = talk.watch("prefilter", |job| filter_lobe(source, lobe, self.size, tolerance, job))?;
        self.output.write(filtered.into(), talk)
    }
}
