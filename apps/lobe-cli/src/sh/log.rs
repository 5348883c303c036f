//! `lobe sh log`: the logarithm of a visibility, so that shadows add up.

use clap::Args;
use lobe::sh::expansion::Quantity;
use lobe::sh::exponential::{LOG_CLAMP, logarithm};
use lobe::sh::sh_json::ShFile;

use crate::args::input::ShInput;
use crate::args::output::ShOutput;
use crate::args::values;
use crate::sh::exp::{by_channel, check_order, expect};

#[derive(Args)]
pub(crate) struct ShLog {
    /// The visibility, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// The least eigenvalue of the product matrix that is kept, as a part of the largest: visibility rings below zero, where
    /// there is no logarithm
    #[arg(long, value_name = "C", default_value_t = LOG_CLAMP, allow_hyphen_values = true, value_parser = values::clamp)]
    clamp: f64,
    /// The logarithm, a .sh.json file of log-visibility; - writes to stdout
    #[arg(short, long, value_name = "Q")]
    output: ShOutput,
}

impl ShLog {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        self.output.check()?;
        let file = self.input.read()?;
        expect(&self.input, file.quantity, Quantity::Visibility)?;
        check_order(&self.input, &file.coefficients)?;
        let logarithm = by_channel(&file.coefficients, |f| logarithm(f, self.clamp));
        self.output.write(&ShFile::new(Quantity::LogVisibility, logarithm))
    }
}
