//! `lobe sh add`: the sum of expansions.

use anyhow::anyhow;
use clap::Args;
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::{FileCoefficients, ShFile};
use lobe::sh::{Coefficient, ShVec};

use crate::args::input::ShInput;
use crate::args::output::{QuantityOption, ShOutput};
use crate::args::values;

#[derive(Args)]
pub(crate) struct ShAdd {
    /// Expansions of the same quantity, .sh.json files; one may be - for stdin. Numbers are added to colors as gray
    #[arg(value_name = "P", required = true, num_args = 2..)]
    inputs: Vec<ShInput>,
    /// The order (number of bands) of the sum, 1 to 256 [default: the highest order of the inputs]
    #[arg(long, value_name = "N", value_parser = values::order)]
    order: Option<usize>,
    #[command(flatten)]
    quantity: QuantityOption,
    /// The sum, a .sh.json file; - writes to stdout
    #[arg(short, long, value_name = "Q")]
    output: ShOutput,
}

impl ShAdd {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        self.output.check()?;
        ShInput::check_stdin_once(&self.inputs)?;
        let files = self.inputs.iter().map(ShInput::read).collect::<anyhow::Result<Vec<_>>>()?;
        let quantity = self.quantity.or(quantity_of_sum(&self.inputs, &files)).map_err(|why| anyhow!("{why}"))?;
        let highest = files.iter().map(|file| file.coefficients.order()).max();
        let order = self.order.or(highest).unwrap_or(1);
        let numbers: Option<Vec<&ShVec<f64>>> = files
            .iter()
            .map(|file| if let FileCoefficients::Scalar(f) = &file.coefficients { Some(f) } else { None })
            .collect();
        let sum: FileCoefficients = match numbers {
            Some(numbers) => sum(numbers.into_iter().cloned(), order).into(),
            None => sum(files.iter().map(|file| file.coefficients.to_rgb()), order).into(),
        };
        self.output.write(&ShFile::new(quantity, sum))
    }
}

/// The quantity of all files; else a message that names the first file of another one.
fn quantity_of_sum(inputs: &[ShInput], files: &[ShFile]) -> Result<Quantity, String> {
    let first = files[0].quantity;
    match inputs.iter().zip(files).find(|(_, file)| file.quantity != first) {
        Some((input, other)) => Err(format!("{input}: {} is not added to {first}", other.quantity)),
        None => Ok(first),
    }
}

fn sum<T: Coefficient>(terms: impl Iterator<Item = ShVec<T>>, order: usize) -> ShVec<T> {
    let mut sum = ShVec::zero(order);
    terms.for_each(|term| sum += &term.resized(order));
    sum
}
