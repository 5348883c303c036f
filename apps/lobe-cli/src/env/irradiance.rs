//! `lobe env irradiance`: the irradiance map of an environment, by spherical harmonics or by brute force.

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::env::{EnvMap, MappedMap, irradiance_at, irradiance_map, irradiance_map_brute_force, project_map};
use lobe::image::PictureWriteOptions;
use lobe::sh::{Dir, Expansion as _, Rgb, Zonal};

use crate::args::map_input::MapInput;
use crate::args::map_output::OF_PICTURE;
use crate::args::output;
use crate::args::picture::PictureOutput;
use crate::args::values;
use crate::run::talk::Talk;

/// The order where none is given: nine coefficients keep the irradiance to a few percent.
const DEFAULT_ORDER: usize = 3;

/// The height of the picture where none is given: irradiance has no detail.
const DEFAULT_SIZE: usize = 64;

#[derive(Args)]
pub(crate) struct EnvIrradiance {
    #[command(flatten)]
    input: MapInput,
    #[arg(short, long, value_name = "OUT", required_unless_present = "dirs", help = PictureOutput::help(
        "A lat-long picture of the irradiance E, not divided by π, for every direction that a surface may face"
    ))]
    output: Option<PictureOutput>,
    /// Print the irradiance of a surface that faces this way, a vector of any length but 0; may be given many times
    #[arg(long = "dir", value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::dir)]
    dirs: Vec<Dir>,
    /// With --dir: print {"values": [[one number per channel] per direction]} instead of one line per direction
    #[arg(long, requires = "dirs")]
    json: bool,
    /// The method of integration
    #[arg(long, value_enum, default_value = "sh")]
    method: Method,
    /// With --method sh: the order (number of bands), 1 to 256 [default: 3]
    #[arg(long, value_name = "N", value_parser = values::order)]
    order: Option<usize>,
    /// Of OUT: the height of the picture in pixels, 1 to 8192; it is twice as wide [default: 64]
    #[arg(long, value_name = "H", requires = "output", value_parser = values::rows)]
    size: Option<usize>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Method {
    /// Convolve the expansion with the clamped cosine: fast, cut off above the order
    Sh,
    /// Sum over all pixels for every direction: slow, nothing cut off
    BruteForce,
}

/// The map in the form that the method takes.
enum Source {
    Any(MappedMap),
    LatLong(EnvMap),
}

impl EnvIrradiance {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        if self.order.is_some() && self.method == Method::BruteForce {
            bail!("--order: --method brute-force has no order; choose sh, or leave the order out");
        }
        if let Some(output) = &self.output {
            output.check(&self.input.files()?)?;
        }
        if self.output.is_some() {
            let height = self.size.unwrap_or(DEFAULT_SIZE) as u64;
            let what = format!("irradiance of {} x {height} texels", 2 * height);
            self.input.memory().check(&what, OF_PICTURE * 2 * height * height, "a smaller --size")?;
        }
        let map = self.input.read(talk)?;
        let order = self.order.unwrap_or(DEFAULT_ORDER);
        let source = match self.method {
            Method::Sh => Source::Any(map),
            Method::BruteForce => Source::LatLong(self.input.to_lat_long(map, talk)?),
        };
        if !self.dirs.is_empty() {
            let irradiance = match &source {
                Source::Any(map) => by_expansion(map, order, &self.dirs),
                Source::LatLong(map) => irradiance_at(map, &self.dirs),
            };
            output::print_values(irradiance.into_iter().map(|e| e.to_array().to_vec()).collect(), self.json)?;
        }
        let Some(output) = &self.output else { return Ok(()) };
        let height = self.size.unwrap_or(DEFAULT_SIZE);
        let irradiance = match &source {
            Source::Any(map) => irradiance_map(map, order, 2 * height, height)?,
            Source::LatLong(map) => {
                talk.watch("irradiance", |job| irradiance_map_brute_force(map, 2 * height, height, job))?
            }
        };
        output.write_map(&irradiance, &PictureWriteOptions::default(), talk)
    }
}

/// The irradiance of surfaces that face `normals`.
fn by_expansion(map: &MappedMap, order: usize, normals: &[Dir]) -> Vec<Rgb<f64>> {
    let irradiance = project_map(map, order).convolved(&Zonal::clamped_cosine(order));
    normals.iter().map(|n| irradiance.eval(*n)).collect()
}
