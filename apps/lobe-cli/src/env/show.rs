//! `lobe env show`: a contact sheet of every technique of environment mapping under one map.

use std::path::PathBuf;

use clap::Args;
use lobe::figures::{EnvironmentSheetOptions, EnvironmentSheetSource, environment_mapping_sheet};
use lobe::image::Tone;

use crate::args::map_input::MapInput;
use crate::args::output;
use crate::args::values;
use crate::env::prefilter::OF_SOURCE;
use crate::run::talk::Talk;

/// The most pixels on a side of one of the pictures.
const MAX_SIZE: usize = 1024;

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
        let map = self.input.read(talk)?;
        self.input.check_work("prefiltering", &map, OF_SOURCE)?;
        let source = talk.watch("prefilter", |job| EnvironmentSheetSource::new(map, job))?;
        let options = EnvironmentSheetOptions::default().size(self.size).prefiltered(&source.chain);
        let sheet = talk.watch("techniques", |job| environment_mapping_sheet(&source.sky, &options, job))?;
        sheet.write_png(&self.output, &Tone::PLAIN)?;
        Ok(())
    }
}
