//! `lobe env sky`: sky models (Preetham, CIE) as a picture or as an expansion.

use std::str::FromStr;

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::env::{CieSky, EnvError, Ground, PreethamFit, PreethamSky, Sky, SkyFitOptions, sky_map, sky_sh};
use lobe::image::PictureWriteOptions;
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::ShFile;
use lobe::sh::{Coefficient as _, Dir, Rgb};

use crate::args::output::ShOutput;
use crate::args::picture::PictureOutput;
use crate::args::values;
use crate::run::talk::Talk;

const DEFAULT_ORDER: usize = 3;
const DEFAULT_ROWS: usize = 256;
const DEFAULT_TURBIDITY: f64 = 3.0;

#[derive(Args)]
pub(crate) struct EnvSky {
    /// preetham: a clear sky in color, in kcd/m² (Preetham et al. 1999); cie: one of the general skies of the CIE
    #[arg(long, value_enum, default_value = "preetham")]
    model: Model,
    /// The direction of the sun, not below the horizon; +z is up
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::dir)]
    sun: Dir,
    /// With preetham: haze, from 2 (very clear) to 10 [default: 3]
    #[arg(long, value_name = "T", allow_hyphen_values = true, value_parser = values::finite)]
    turbidity: Option<f64>,
    /// With cie: the type, 1 (overcast, steep gradation) to 15 (cloudless, turbid), or 16 (the traditional overcast sky)
    #[arg(long = "type", value_name = "K", value_parser = sky_type)]
    kind: Option<usize>,
    /// With cie: the radiance of the zenith [default: 1,1,1]
    #[arg(long, value_name = "R,G,B", allow_hyphen_values = true, value_parser = values::color)]
    zenith: Option<Rgb<f64>>,
    /// The albedo of the ground, 0 to 1 in each channel
    #[arg(long, value_name = "R,G,B", default_value = "0,0,0", allow_hyphen_values = true, value_parser = values::albedo)]
    ground: Rgb<f64>,
    /// The irradiance of the sun on the ground, which the ground reflects; the disc of the sun is never part of the sky
    #[arg(long, value_name = "R,G,B", default_value = "0,0,0", allow_hyphen_values = true, value_parser = values::color)]
    sun_irradiance: Rgb<f64>,
    #[arg(short, long, value_name = "OUT", help = PictureOutput::help(
        "The expansion of the formula itself, a .sh.json file or - for stdout, or a lat-long picture"
    ))]
    output: SkyOutput,
    /// Of a picture: its height in pixels, 1 to 8192; it is twice as wide [default: 256]
    #[arg(long, value_name = "H", value_parser = values::rows)]
    size: Option<usize>,
    /// Of an expansion: its order (number of bands), 1 to 256 [default: 3]
    #[arg(long, value_name = "N", value_parser = values::order)]
    order: Option<usize>,
    /// Of an expansion of preetham: by the polynomials in the sun's height and the turbidity instead of by integration
    #[arg(long)]
    fit: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Model {
    Preetham,
    Cie,
}

/// A picture or an expansion; the name says which.
#[derive(Clone, Debug, PartialEq)]
enum SkyOutput {
    Picture(PictureOutput),
    Expansion(ShOutput),
}

impl FromStr for SkyOutput {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "-" || text.ends_with(".json") {
            return Ok(Self::Expansion(ShOutput::from(std::ffi::OsString::from(text))));
        }
        match text.parse() {
            Ok(picture) => Ok(Self::Picture(picture)),
            Err(_) => Err(format!("expected a name that ends in .sh.json, {}", PictureOutput::endings())),
        }
    }
}

fn sky_type(text: &str) -> Result<usize, String> {
    values::whole(text, 1, 16, "a type of sky")
}

impl EnvSky {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.check_options()?;
        match self.model {
            Model::Preetham => {
                let turbidity = self.turbidity.unwrap_or(DEFAULT_TURBIDITY);
                self.write(&PreethamSky::new(turbidity, self.sun).map_err(|e| by_option(&e))?, talk)
            }
            Model::Cie => {
                let Some(kind) = self.kind else { bail!("--type: --model cie needs one of its types, 1 to 16") };
                let zenith = self.zenith.unwrap_or(Rgb::splat(1.0));
                self.write(&CieSky::new(kind, self.sun, zenith).map_err(|e| by_option(&e))?, talk)
            }
        }
    }

    /// Refuses options that would be ignored.
    fn check_options(&self) -> anyhow::Result<()> {
        let is_picture = matches!(self.output, SkyOutput::Picture(_));
        let has_ground = self.ground != Rgb::splat(0.0);
        let ignored = [
            (
                self.turbidity.is_some() && self.model == Model::Cie,
                "--turbidity: --model cie has none; give its --type",
            ),
            (self.kind.is_some() && self.model == Model::Preetham, "--type: only --model cie has types"),
            (self.zenith.is_some() && self.model == Model::Preetham, "--zenith: preetham knows it; choose --model cie"),
            (self.order.is_some() && is_picture, "--order: a picture has none; name a .sh.json file as output"),
            (self.size.is_some() && !is_picture, "--size: an expansion has none; name a picture as output"),
            (self.fit && is_picture, "--fit: only expansions are fitted; name a .sh.json file as output"),
            (self.fit && self.model == Model::Cie, "--fit: only --model preetham is fitted"),
            (self.fit && has_ground, "--fit: the fitted sky has black ground; leave --ground or --fit out"),
            (
                self.sun_irradiance != Rgb::splat(0.0) && !has_ground,
                "--sun-irradiance: black --ground reflects nothing",
            ),
        ];
        match ignored.into_iter().find(|(is_ignored, _)| *is_ignored) {
            Some((_, message)) => bail!(message),
            None => Ok(()),
        }
    }

    fn write(&self, sky: &impl Sky, talk: Talk) -> anyhow::Result<()> {
        let ground = Ground { albedo: self.ground, sun: self.sun_irradiance };
        match &self.output {
            SkyOutput::Picture(output) => {
                output.check(&[])?;
                let rows = self.size.unwrap_or(DEFAULT_ROWS);
                output.write_map(&sky_map(sky, &ground, 2 * rows, rows), &PictureWriteOptions::default(), talk)
            }
            SkyOutput::Expansion(output) => {
                output.check()?;
                let order = self.order.unwrap_or(DEFAULT_ORDER);
                let f = if self.fit {
                    let fit = PreethamFit::new(SkyFitOptions::default().order(order))?;
                    fit.eval(self.turbidity.unwrap_or(DEFAULT_TURBIDITY), self.sun)
                } else {
                    sky_sh(sky, &ground, order)
                };
                output.write(&ShFile::new(Quantity::Radiance, f))
            }
        }
    }
}

/// Says which option a sky cannot take.
fn by_option(error: &EnvError) -> anyhow::Error {
    let message = error.to_string();
    let option = if message.contains("turbidity") { "--turbidity" } else { "--sun" };
    anyhow::anyhow!("{option}: {message}")
}
