//! `lobe env irradiance`: the irradiance map of an environment, by spherical harmonics or by brute force.

use std::f64::consts::FRAC_1_PI;

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::env::{
    EnvMap, MappedMap, Mapping, irradiance_at, irradiance_cube, irradiance_map, irradiance_map_brute_force,
    project_map, scale_in_place,
};
use lobe::sh::{Coefficient as _, Dir, Expansion as _, Rgb, Zonal};

use crate::args::map_input::MapInput;
use crate::args::map_output::{MapFile, MapOutput};
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
        "The irradiance E for every direction that a surface may face; as .ktx2, .dds, .ktx or FOLDER/PREFIX%.exr a cube"
    ))]
    output: Option<MapFile>,
    /// How OUT shows the directions [default: cube for .ktx2, .dds, .ktx and six files, else lat-long]
    #[arg(long, value_enum, requires = "output")]
    to: Option<Shown>,
    /// Divide by π: not the irradiance, but what a white matte surface leaves of it, as the diffuse maps of bevy and
    /// glTF viewers
    #[arg(long)]
    over_pi: bool,
    /// Of a cube: make its faces for left-handed directions, as Direct3D, bevy and three.js want them
    #[arg(long, requires = "output")]
    left_handed: bool,
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
    /// Of OUT: the height of the picture in pixels, 1 to 8192, which is twice as wide; of a cube the size of a face
    /// [default: 64]
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

/// The mapping of the result.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Shown {
    /// A picture twice as wide as high
    LatLong,
    /// Six faces
    Cube,
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
        let output = self.output()?;
        if let Some((output, mapping)) = &output {
            output.check(*mapping, &self.input.files()?)?;
            let [width, height] = mapping.picture_size(self.size());
            let bytes = output.bytes_of_texel(*mapping) * (width * height) as u64;
            self.input.memory().check(
                &format!("irradiance of {width} x {height} texels"),
                bytes,
                "a smaller --size",
            )?;
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
            let values = irradiance.into_iter().map(|e| e.scale(self.factor()).to_array().to_vec());
            output::print_values(values.collect(), self.json)?;
        }
        let Some((output, mapping)) = output else { return Ok(()) };
        let size = self.size();
        let mut irradiance: MappedMap = match &source {
            Source::Any(map) if mapping == Mapping::Cube => irradiance_cube(map, order, size)?.into(),
            Source::Any(map) => irradiance_map(map, order, 2 * size, size)?.into(),
            Source::LatLong(map) => {
                talk.watch("irradiance", |job| irradiance_map_brute_force(map, 2 * size, size, job))?.into()
            }
        };
        if self.over_pi {
            scale_in_place(&mut irradiance, Rgb::splat(self.factor()))?;
        }
        output.write(irradiance, talk)
    }

    /// The output and its mapping.
    fn output(&self) -> anyhow::Result<Option<(MapOutput, Mapping)>> {
        let Some(file) = &self.output else { return Ok(None) };
        let output = MapOutput::of(file.clone(), self.left_handed);
        let is_cube = self.to.map_or(output.is_cube_only(), |to| to == Shown::Cube);
        if is_cube && self.method == Method::BruteForce {
            bail!(
                "--method: brute-force writes a lat-long picture only; choose sh, or lobe env convert makes a cube of it"
            );
        }
        Ok(Some((output, if is_cube { Mapping::Cube } else { Mapping::LatLong })))
    }

    /// The height of the picture, or the size of a face.
    fn size(&self) -> usize {
        self.size.unwrap_or(DEFAULT_SIZE)
    }

    /// What the irradiance is multiplied by.
    fn factor(&self) -> f64 {
        if self.over_pi { FRAC_1_PI } else { 1.0 }
    }
}

/// The irradiance of surfaces that face `normals`.
fn by_expansion(map: &MappedMap, order: usize, normals: &[Dir]) -> Vec<Rgb<f64>> {
    let irradiance = project_map(map, order).convolved(&Zonal::clamped_cosine(order));
    normals.iter().map(|n| irradiance.eval(*n)).collect()
}
