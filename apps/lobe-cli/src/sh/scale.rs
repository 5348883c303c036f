//! `lobe sh scale`: an expansion times a number or a color.

use clap::Args;
use lobe::sh::{Coefficient as _, FileCoefficients, Rgb, ShFile};

use crate::args::input::ShInput;
use crate::args::output::ShOutput;
use crate::args::values;

#[derive(Args)]
pub(crate) struct ShScale {
    /// The expansion, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// The factor, or one for each channel; numbers become colors by three that differ
    #[arg(long, value_name = "X|R,G,B", allow_hyphen_values = true, value_parser = factor)]
    by: Rgb<f64>,
    /// The expansion times the factor, a .sh.json file; - writes to stdout
    #[arg(short, long, value_name = "Q")]
    output: ShOutput,
}

fn factor(text: &str) -> Result<Rgb<f64>, String> {
    if text.contains(',') { values::numbers(text).map(Rgb::from) } else { values::finite(text).map(Rgb::splat) }
}

impl ShScale {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        self.output.check()?;
        let ShFile { quantity, coefficients } = self.input.read()?;
        let scaled: FileCoefficients = match coefficients {
            FileCoefficients::Scalar(f) if self.by == Rgb::splat(self.by.r) => f.map(|c| c * self.by.r).into(),
            f => f.to_rgb().map(|c| Rgb::from_channels(|k| c.channel(k) * self.by.channel(k))).into(),
        };
        self.output.write(&ShFile::new(quantity, scaled))
    }
}
