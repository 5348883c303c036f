//! `lobe env reconstruct`: an expansion as a lat-long picture.

use clap::Args;
use lobe::env::reconstruct;
use lobe::image::PictureWriteOptions;

use crate::args::input::ShInput;
use crate::args::picture::PictureOutput;
use crate::args::values;
use crate::run::talk::Talk;

#[derive(Args)]
pub(crate) struct EnvReconstruct {
    /// The expansion, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    #[arg(short, long, value_name = "OUT", help = PictureOutput::help("A lat-long picture of the expansion"))]
    output: PictureOutput,
    /// The height of the picture in pixels, 1 to 8192; it is twice as wide
    #[arg(long, value_name = "H", default_value = "256", value_parser = values::rows)]
    size: usize,
}

impl EnvReconstruct {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.output.check(&[])?;
        let f = self.input.read()?.coefficients.to_rgb();
        self.output.write_map(&reconstruct(&f, 2 * self.size, self.size), &PictureWriteOptions::default(), talk)
    }
}
