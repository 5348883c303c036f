//! `lobe compare`: RMSE, relative MSE, PSNR and FLIP of two pictures, a test by their variance, and the error over
//! surfaces against two halves of a reference.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::env::FileFormat;
use lobe::image::{
    ErrorReport, FLIP_PIXELS_PER_DEGREE, Flip, HalvesReport, Measured, Picture, PictureReadOptions, Tone, ZTest,
    compare, flip, hdr_flip, read_picture, relative_mse,
};
use lobe::render::{TracedPicture, read_traced_picture};
use serde::Serialize;

use crate::args::input::{tell, without_options};
use crate::args::memory::{DEFAULT_GIB, MemoryLimit};
use crate::args::output;
use crate::args::values;
use crate::run::talk::Talk;

/// The probability that two pictures of the same light are told apart by mistake.
const SIGNIFICANCE: f64 = 0.01;

/// The least degrees of freedom of a variance that is tested, one fewer than paths in a pixel where these are few.
const LEAST_FREEDOM: f64 = 5.0;

#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Args)]
pub(crate) struct Compare {
    #[arg(value_name = "A", help = format!("A picture: {}", FileFormat::names(|format| !format.is_texture())))]
    image: PathBuf,
    /// The reference it is compared with, of the same size
    #[arg(value_name = "B")]
    reference: PathBuf,
    /// The measure that --max bounds [default: rmse]
    #[arg(long, value_enum, requires = "max")]
    metric: Option<Metric>,
    /// Exit with 1 if the measure is above this; psnr: below
    #[arg(long, value_name = "X", value_parser = values::finite)]
    max: Option<f64>,
    /// Write the FLIP error of every pixel as a .png: black for none, white for the largest
    #[arg(short, long, value_name = "DIFF")]
    output: Option<PathBuf>,
    /// Test whether chance explains the differences of two .exr pictures of lobe render trace; exit with 1 if not. The
    /// level of significance is 1 % for all six numbers together (Šidák)
    #[arg(long)]
    z_test: bool,
    /// Another reference by lobe render trace, like B except for its --seed: adds the error over surfaces, with
    /// the noise of both references subtracted. Only pixels that show nothing else count
    #[arg(long, value_name = "B2", conflicts_with = "z_test")]
    half: Option<PathBuf>,
    /// Pixels per degree of visual angle, for FLIP [default: 67, a 4K display as wide as it is far away]
    #[arg(long, value_name = "N", value_parser = values::positive)]
    pixels_per_degree: Option<f64>,
    /// Print {"rmse", "relmse", "psnr", "flip"} instead of text, with --z-test also {"z_test": {"mean_z", "p_bias", "spread",
    /// "p_spread"}}, with --half {"surfaces": {"pixels", "relative_rms", "uncertainty", "mean_ratio", "psnr", "noise",
    /// "dark"}}; psnr is null for equal pictures
    #[arg(long)]
    json: bool,
    /// Refuse pictures that take more memory than this, in GiB
    #[arg(long, value_name = "GIB", default_value_t = DEFAULT_GIB, value_parser = values::positive)]
    max_memory: f64,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Metric {
    /// The root of the mean squared difference of linear light
    Rmse,
    /// The mean squared difference relative to the reference, (a-b)²/(b² + 0.01 mean²)
    Relmse,
    /// Peak signal-to-noise ratio in decibels; the peak is the reference's largest value
    Psnr,
    /// The difference that one sees when flipping between them, 0 to 1: FLIP for .png and .jpg, HDR-FLIP for light
    Flip,
    /// With --half: the root mean square error over surfaces relative to that of the reference, its noise subtracted
    Surfaces,
}

/// The JSON of `--json`.
#[derive(Serialize)]
struct Found {
    rmse: f64,
    relmse: f64,
    psnr: f64,
    flip: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    z_test: Option<FoundZ>,
    #[serde(skip_serializing_if = "Option::is_none")]
    surfaces: Option<FoundSurfaces>,
}

#[derive(Serialize)]
struct FoundSurfaces {
    pixels: usize,
    relative_rms: f64,
    uncertainty: f64,
    mean_ratio: f64,
    psnr: f64,
    noise: f64,
    dark: f64,
}

#[derive(Serialize)]
struct FoundZ {
    mean_z: [f64; 3],
    p_bias: [f64; 3],
    spread: [f64; 3],
    p_spread: [f64; 3],
}

/// A picture, and whether it is made for a display.
struct Read {
    picture: Picture,
    is_display: bool,
    /// The variance of a traced picture, and its degrees of freedom.
    variance: Option<(Picture, f64)>,
}

impl Read {
    /// The picture with its variance; none if it was read without.
    fn measured(&self) -> Option<Measured<'_>> {
        let (variance, degrees_of_freedom) = self.variance.as_ref()?;
        let (means, variances) = (self.picture.pixels(), variance.pixels());
        Some(Measured { means, variances, degrees_of_freedom: *degrees_of_freedom })
    }
}

impl Compare {
    /// Whether the pictures are as close as the options ask for.
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<bool> {
        if self.metric == Some(Metric::Surfaces) && self.half.is_none() {
            bail!("--metric surfaces: expected --half B2, another reference of a different --seed");
        }
        if let Some(path) = &self.output {
            output::check_png(path)?;
            output::prepare_file(path, &[&self.image, &self.reference])?;
        }
        let memory = self.memory();
        let read = |path| if self.z_test { read_traced(path, &memory) } else { read(path, &memory, talk) };
        let (image, reference) = (read(&self.image)?, read(&self.reference)?);
        let (a, b) = (&image.picture, &reference.picture);
        let flip = self.flip(&image, &reference)?;
        let ErrorReport { rmse, psnr, .. } = compare(a.pixels(), b.pixels());
        let relmse = relative_mse(a.pixels(), b.pixels());
        let z_test = self.z_test(&image, &reference)?;
        let surfaces = self.surfaces(&image)?;
        if let Some(path) = &self.output {
            flip.picture().write_png(path, &Tone::PLAIN)?;
        }
        let found =
            Found {
                rmse,
                relmse,
                psnr,
                flip: flip.mean(),
                z_test: z_test.map(|ZTest { mean_z, p_bias, spread, p_spread, .. }| FoundZ {
                    mean_z,
                    p_bias,
                    spread,
                    p_spread,
                }),
                surfaces: surfaces.map(
                    |HalvesReport { pixels, relative_rms, uncertainty, mean_ratio, psnr, noise, dark, .. }| {
                        FoundSurfaces { pixels, relative_rms, uncertainty, mean_ratio, psnr, noise, dark }
                    },
                ),
            };
        if self.json {
            output::print_json(&found)?;
        } else {
            output::print(&text(&found))?;
        }
        Ok(self.is_close(&found) && z_test.is_none_or(|test| test.passes(SIGNIFICANCE)))
    }

    /// The test by variance; none if the pictures were read without.
    fn z_test(&self, image: &Read, reference: &Read) -> anyhow::Result<Option<ZTest>> {
        let Some((a, b)) = image.measured().zip(reference.measured()) else { return Ok(None) };
        for (path, measured) in [(&self.image, &a), (&self.reference, &b)] {
            let (place, found) = (path.display(), measured.degrees_of_freedom);
            if found < LEAST_FREEDOM {
                bail!(
                    "{place}: expected a variance of at least {LEAST_FREEDOM} degrees of freedom, found {found}; \
                     lobe render --samples {} or more gives it",
                    LEAST_FREEDOM + 1.0
                );
            }
        }
        Ok(Some(ZTest::new(&a, &b)?))
    }

    /// The error over surfaces, the noise of the reference subtracted; none without another reference.
    fn surfaces(&self, image: &Read) -> anyhow::Result<Option<HalvesReport>> {
        let Some(half) = &self.half else { return Ok(None) };
        let memory = self.memory();
        let halves = [&self.reference, half].map(|path| traced(path, &memory));
        let [a, b] = halves;
        let (a, b) = (a?, b?);
        let size = |picture: &Picture| (picture.width(), picture.height());
        if size(&a.mean) != size(&b.mean) {
            let ((w, h), (v, g)) = (size(&a.mean), size(&b.mean));
            bail!("{}: expected {w} x {h} pixels as {} has, found {v} x {g}", half.display(), self.reference.display());
        }
        if a.mean == b.mean {
            bail!(
                "{}: expected another --seed than that of {}, found the same",
                half.display(),
                self.reference.display()
            );
        }
        let is_surface = |i: usize| [&a, &b].iter().all(|of| of.coverage.get(i).is_none_or(|&part| part >= 1.0));
        let halves = [a.mean.pixels(), b.mean.pixels()];
        let report = HalvesReport::new(image.picture.pixels(), halves, is_surface);
        Ok(Some(report.map_err(|error| anyhow::anyhow!("{}: {error}", self.image.display()))?))
    }

    fn memory(&self) -> MemoryLimit {
        MemoryLimit::of(self.max_memory)
    }

    fn is_close(&self, found: &Found) -> bool {
        let Some(max) = self.max else { return true };
        match self.metric.unwrap_or(Metric::Rmse) {
            Metric::Rmse => found.rmse <= max,
            Metric::Relmse => found.relmse <= max,
            Metric::Psnr => found.psnr >= max,
            Metric::Flip => found.flip <= max,
            Metric::Surfaces => found.surfaces.as_ref().is_none_or(|report| report.relative_rms <= max),
        }
    }

    fn flip(&self, image: &Read, reference: &Read) -> anyhow::Result<Flip> {
        let per_degree = self.pixels_per_degree.unwrap_or(FLIP_PIXELS_PER_DEGREE);
        let is_display = image.is_display && reference.is_display;
        let of = if is_display { flip } else { hdr_flip };
        let named = |error| {
            let (a, b) = (self.image.display(), self.reference.display());
            anyhow::anyhow!("{a} and {b}: {error}")
        };
        of(&image.picture, &reference.picture, per_degree).map_err(named)
    }
}

/// Advice on a picture that is too large or has pixels that are no numbers.
const TO_DO: [&str; 2] = ["scale both down", "only numbers can be compared"];

fn read(path: &Path, memory: &MemoryLimit, talk: Talk) -> anyhow::Result<Read> {
    let read = read_picture(path, &PictureReadOptions::default().max_bytes(memory.bytes()));
    let (picture, report) = read.map_err(|error| without_options(error.into(), TO_DO))?;
    let is_display = matches!(report.format, FileFormat::Png | FileFormat::Jpeg);
    tell(&report, &path.display().to_string(), talk);
    Ok(Read { picture, is_display, variance: None })
}

/// A picture of `lobe render trace`, with its variance.
fn read_traced(path: &Path, memory: &MemoryLimit) -> anyhow::Result<Read> {
    let TracedPicture { mean, variance, degrees_of_freedom, .. } = traced(path, memory)?;
    Ok(Read { picture: mean, is_display: false, variance: Some((variance, degrees_of_freedom)) })
}

fn traced(path: &Path, memory: &MemoryLimit) -> anyhow::Result<TracedPicture> {
    memory.check_file(path, "smaller pictures")?;
    Ok(read_traced_picture(path)?)
}

fn text(found: &Found) -> String {
    let Found { rmse, relmse, psnr, flip, z_test, surfaces } = found;
    let mut text = format!("rmse    {rmse:.6}\nrelmse  {relmse:.6}\npsnr    {psnr:.3} dB\nflip    {flip:.6}\n");
    if let Some(z) = z_test {
        for (c, name) in ["red", "green", "blue"].into_iter().enumerate() {
            text += &format!(
                "z-test  {name:<5} mean z {:+.4} (p {:.3}), spread {:.4} (p {:.3})\n",
                z.mean_z[c], z.p_bias[c], z.spread[c], z.p_spread[c]
            );
        }
    }
    if let Some(FoundSurfaces { pixels, relative_rms, uncertainty, mean_ratio, psnr, noise, dark }) = surfaces {
        let [rms, by, noise, dark] = [relative_rms, uncertainty, noise, dark].map(|part| 100.0 * part);
        text += &format!(
            "surfaces: rms {rms:.2} % ± {by:.2} %, mean ratio {mean_ratio:.3}, psnr {psnr:.1} dB, dark {dark:.2} %; \
             {pixels} pixels, noise of the reference {noise:.1} %\n"
        );
    }
    text
}
