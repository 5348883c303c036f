//! `lobe env dfg`: the DFG table of the split sum, which goes with prefiltered maps.

use clap::Args;
use lobe::env::DfgTable;
use lobe::image::{Picture, PictureWriteOptions};

use crate::args::picture::PictureOutput;
use crate::args::values;
use crate::run::talk::Talk;

/// The most texels on a side: above this the table takes minutes, and linear interpolation gains nothing.
const MAX_SIZE: usize = 1024;

#[derive(Args)]
pub(crate) struct EnvDfg {
    #[arg(short, long, value_name = "OUT", help = PictureOutput::help(
        "A square picture: red is A, green is B of the reflectance F0 A + B of GGX in even light; from left to right the \
         cosine of the view rises from 0 to 1, from the top down the roughness √alpha"
    ))]
    output: PictureOutput,
    /// The number of texels on a side, 1 to 1024
    #[arg(long, value_name = "N", default_value = "64", value_parser = size)]
    size: usize,
}

fn size(text: &str) -> Result<usize, String> {
    values::whole(text, 1, MAX_SIZE, "a number of texels")
}

impl EnvDfg {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.output.check(&[])?;
        let table = DfgTable::new(self.size);
        let texels: Vec<[f32; 3]> = table.texels().iter().map(|dfg| [dfg.scale as f32, dfg.bias as f32, 0.0]).collect();
        self.output.write(&Picture::new(self.size, self.size, texels)?, &PictureWriteOptions::default(), talk)
    }
}
