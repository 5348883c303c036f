//! `lobe env reconstruct`: an expansion as a lat-long picture.

use clap::Args;
use lobe::env::reconstruct;
use lobe::image::PictureWriteOptions;
use lobe::sh::{Expansion as _, Rgb, ShVec};

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
        let map = reconstruct(&f, 2 * self.size, self.size);
        let below = below_zero(map.texels(), &f);
        // Files of light hold what is below zero, too.
        if below > 0.0 && !self.output.is_light() {
            let text =
                "of its pixels are below zero and black; lobe sh dering or window stops the ringing of an expansion";
            talk.note(&self.output.name(), &format!("{:.2} % {text}", 100.0 * below));
        }
        self.output.write_map(&map, &PictureWriteOptions::default(), talk)
    }
}

/// The part of the texels in which some channel is below zero by more than a thousandth of the mean: dark spots, not
/// rounding.
fn below_zero(texels: &[Rgb<f32>], f: &ShVec<Rgb<f64>>) -> f64 {
    let least = -1e-3 * f.mean().luminance().abs();
    let is_below = |texel: &&Rgb<f32>| texel.to_array().into_iter().any(|c| f64::from(c) < least);
    texels.iter().filter(is_below).count() as f64 / texels.len() as f64
}
