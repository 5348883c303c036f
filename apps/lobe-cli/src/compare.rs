//! `lobe compare`: RMSE, relative MSE, PSNR and FLIP of two pictures, and a test by their variance.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::env::FileFormat;
use lobe::image::{
    ErrorReport, FLIP_PIXELS_PER_DEGREE, Flip, Measured, Picture, PictureReadOptions, Tone, ZTest, compare, flip,
    hdr_flip, read_picture, relative_mse,
};
use lobe::render::{TracedPicture, read_traced_picture};
use serde::Serialize;

use crate::args::input::{tell, without_options};
use crate::args::memory::MemoryLimit;
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
    /// A picture: .png, .jpg, .hdr, .exr or .pfm
    #[arg(value_name = "A")]
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
    /// Test whether chance explains the differences of two .exr pictures of lobe render --mode truth; exit with 1 if not. The
    /// level of significance is 1 % for all six numbers together (Šidák)
    #[arg(long)]
    z_test: bool,
    /// Pixels per degree of visual angle, for FLIP [default: 67, a 4K display as wide as it is far away]
    #[arg(long, value_name = "N", value_parser = values::positive)]
    pixels_per_degree: Option<f64>,
    /// Print {"rmse", "relmse", "psnr", "flip"} instead of text, with --z-test also {"z_test": {"mean_z", "p_bias", "spread",
    /// "p_spread"}}; psnr is null for equal pictures
    #[arg(long)]
    json: bool,
    /// With --z-test, refuse pictures that take more memory than this, in GiB [default: 4]
    #[arg(long, value_name = "GIB", requires = "z_test", value_parser = values::positive)]
    max_memory: Option<f64>,
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
        if let Some(path) = &self.output {
            output::check_png(path)?;
            output::prepare_file(path, &[&self.image, &self.reference])?;
        }
        let read =
            |path| if self.z_test { read_traced(path, &MemoryLimit::of(self.max_memory)) } else { read(path, talk) };
        let (image, reference) = (read(&self.image)?, read(&self.reference)?);
        let (a, b) = (&image.picture, &reference.picture);
        let flip = self.flip(&image, &reference)?;
        let ErrorReport { rmse, psnr, .. } = compare(a.pixels(), b.pixels());
        let relmse = relative_mse(a.pixels(), b.pixels());
        let z_test = self.z_test(&image, &reference)?;
        if let Some(path) = &self.output {
            flip.picture().write_png(path, &Tone::PLAIN)?;
        }
        let found = Found {
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

    fn is_close(&self, found: &Found) -> bool {
        let Some(max) = self.max else { return true };
        match self.metric.unwrap_or(Metric::Rmse) {
            Metric::Rmse => found.rmse <= max,
            Metric::Relmse => found.relmse <= max,
            Metric::Psnr => found.psnr >= max,
            Metric::Flip => found.flip <= max,
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

fn read(path: &Path, talk: Talk) -> anyhow::Result<Read> {
    let read = read_picture(path, &PictureReadOptions::default());
    let (picture, report) = read.map_err(|error| without_options(error.into(), TO_DO))?;
    let is_display = matches!(report.format, FileFormat::Png | FileFormat::Jpeg);
    tell(&report, &path.display().to_string(), talk);
    Ok(Read { picture, is_display, variance: None })
}

/// A picture of `lobe render --mode truth`, with its variance.
fn read_traced(path: &Path, memory: &MemoryLimit) -> anyhow::Result<Read> {
    memory.check_file(path, "smaller pictures")?;
    let TracedPicture { mean, variance, degrees_of_freedom, .. } = read_traced_picture(path)?;
    Ok(Read { picture: mean, is_display: false, variance: Some((variance, degrees_of_freedom)) })
}

fn text(found: &Found) -> String {
    let Found { rmse, relmse, psnr, flip, z_test } = found;
    let mut text = format!("rmse    {rmse:.6}\nrelmse  {relmse:.6}\npsnr    {psnr:.3} dB\nflip    {flip:.6}\n");
    if let Some(z) = z_test {
        for (c, name) in ["red", "green", "blue"].into_iter().enumerate() {
            text += &format!(
                "z-test  {name:<5} mean z {:+.4} (p {:.3}), spread {:.4} (p {:.3})\n",
                z.mean_z[c], z.p_bias[c], z.spread[c], z.p_spread[c]
            );
        }
    }
    text
}
