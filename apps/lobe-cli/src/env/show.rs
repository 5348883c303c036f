//! `lobe env show`: a contact sheet of every technique of environment mapping under one map.

use std::path::PathBuf;

use clap::Args;
use lobe::env::{MappedMap, Mapping, PrefilterOptions, Resample, prefilter_ggx, resample};
use lobe::image::Tone;
use lobe::render::{EnvironmentSheetOptions, environment_mapping_sheet};

use crate::args::map_input::MapInput;
use crate::args::output;
use crate::args::values;
use crate::run::talk::Talk;

/// The most pixels on a side of one of the pictures.
const MAX_SIZE: usize = 1024;
/// The size of the faces from which mirrors are blurred, and of the first and the last level of the chain.
const CHAIN: [usize; 3] = [256, 128, 8];

#[derive(Args)]
pub(crate) struct EnvShow {
    #[command(flatten)]
    input: MapInput,
    /// A .png with a ball and a torus under the map, by each technique beside the truth: mirrors by lat-long, sphere map,
    /// cube and paraboloids; rough mirrors by filtered maps; highlight maps; matte by irradiance map and by nine
    /// coefficients; bumps; blended views. The numbers are errors over the visible surface
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// The pixels on a side of each picture, 32 to 1024
    #[arg(long, value_name = "N", default_value = "192", value_parser = size)]
    size: usize,
}

fn size(text: &str) -> Result<usize, String> {
    values::whole(text, 32, MAX_SIZE, "a number of pixels")
}

impl EnvShow {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        output::check_png(&self.output)?;
        output::prepare_file(&self.output, &self.input.files()?)?;
        let map: MappedMap = self.input.read(talk)?;
        let [fine, size, last_size] = CHAIN;
        let to = Resample::to(Mapping::Cube, fine, Mapping::Cube.height_for(fine));
        let cube = talk.watch("convert", |job| resample(&map, &to, job))?.into_cube_map()?;
        let options = PrefilterOptions::default().size(size).last_size(last_size);
        let chain = talk.watch("prefilter", |job| prefilter_ggx(&cube, &options, job))?;
        let sky = if map.mapping() == Mapping::LatLong {
            map
        } else {
            let to = Resample::to(Mapping::LatLong, 8 * fine, 4 * fine);
            talk.watch("convert", |job| resample(map, &to, job))?
        };
        let options = EnvironmentSheetOptions::default().size(self.size).prefiltered(&chain);
        let sky = sky.into_env_map()?;
        let sheet = talk.watch("techniques", |job| environment_mapping_sheet(&sky, &options, job))?;
        sheet.write_png(&self.output, &Tone::PLAIN)?;
        Ok(())
    }
}
