//! `lobe sh scale`: an expansion times a number or a color, at another order.

use anyhow::anyhow;
use clap::Args;
use lobe::sh::sh_json::{FileCoefficients, ShFile};
use lobe::sh::{Coefficient, Expansion as _, Rgb, ShVec};

use crate::args::input::ShInput;
use crate::args::output::{QuantityOption, ShOutput};
use crate::args::values;

#[derive(Args)]
pub(crate) struct ShScale {
    /// The expansion, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// The factor, or one for each channel; numbers become colors by three that differ
    #[arg(long, value_name = "X|R,G,B", allow_hyphen_values = true, value_parser = factor, default_value = "1")]
    by: Rgb<f64>,
    /// Cut off, or filled up with zeros, to this order (number of bands), 1 to 256 [default: that of the input]
    #[arg(long, value_name = "N", value_parser = values::order)]
    order: Option<usize>,
    #[command(flatten)]
    quantity: QuantityOption,
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
            FileCoefficients::Scalar(f) if self.by == Rgb::splat(self.by.r) => {
                self.resized(&f).map(|c| c * self.by.r).into()
            }
            f => {
                let scaled = |c: Rgb<f64>| Rgb::from_channels(|k| c.channel(k) * self.by.channel(k));
                self.resized(&f.to_rgb()).map(scaled).into()
            }
        };
        let quantity = self.quantity.or(Ok(quantity)).map_err(|why: String| anyhow!("{why}"))?;
        self.output.write(&ShFile::new(quantity, scaled))
    }

    fn resized<T: Coefficient>(&self, f: &ShVec<T>) -> ShVec<T> {
        f.resized(self.order.unwrap_or(f.order()))
    }
}
