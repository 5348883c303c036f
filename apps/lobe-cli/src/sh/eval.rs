//! `lobe sh eval`: the values of an expansion.

use clap::Args;
use lobe::sh::sh_json::FileCoefficients;
use lobe::sh::{Coefficient, Dir, Expansion};

use crate::args::input::ShInput;
use crate::args::output;
use crate::args::values;

#[derive(Args)]
pub(crate) struct ShEval {
    /// The expansion, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// A direction to look towards, a vector of any length but 0 (+z is up); may be given many times
    #[arg(long = "dir", value_name = "X,Y,Z", required = true, allow_hyphen_values = true, value_parser = values::dir)]
    dirs: Vec<Dir>,
    /// Print {"values": [[one number per channel] per direction]} instead of one line per direction
    #[arg(long)]
    json: bool,
}

impl ShEval {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let values = match self.input.read()?.coefficients {
            FileCoefficients::Scalar(f) => values_towards(&f, &self.dirs),
            FileCoefficients::Rgb(f) => values_towards(&f, &self.dirs),
        };
        output::print_values(values, self.json)
    }
}

/// The channels of the value towards each direction.
fn values_towards<T: Coefficient<Scalar = f64>>(f: &impl Expansion<T>, dirs: &[Dir]) -> Vec<Vec<f64>> {
    let channels = |value: T| (0..T::CHANNELS).map(|c| value.channel(c)).collect();
    dirs.iter().map(|dir| channels(f.eval(*dir))).collect()
}
