//! `lobe sh product`: the product of two functions.

use anyhow::bail;
use clap::Args;
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::{FileCoefficients, ShFile};

use crate::args::input::ShInput;
use crate::args::output::{QuantityOption, ShOutput};
use crate::args::values;

#[derive(Args)]
pub(crate) struct ShProduct {
    /// The first expansion, a .sh.json file; - reads stdin
    #[arg(value_name = "A")]
    a: ShInput,
    /// The second expansion, a .sh.json file; - reads stdin. Colors may be multiplied by numbers
    #[arg(value_name = "B")]
    b: ShInput,
    /// The order (number of bands) of the product, 1 to 256 [default: the higher order of A and B]
    #[arg(long, value_name = "N", value_parser = values::order)]
    order: Option<usize>,
    #[command(flatten)]
    quantity: QuantityOption,
    /// The product, a .sh.json file; - writes to stdout
    #[arg(short, long, value_name = "C")]
    output: ShOutput,
}

impl ShProduct {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        self.output.check()?;
        let (a, b) = ShInput::read_two(&self.a, &self.b)?;
        let quantity = match self.quantity.or(quantity_of_product(a.quantity, b.quantity)) {
            Ok(quantity) => quantity,
            Err(why) => bail!("{} and {}: {why}", self.a, self.b),
        };
        let order = self.order.unwrap_or(a.coefficients.order().max(b.coefficients.order()));
        let c: FileCoefficients = match (&a.coefficients, &b.coefficients) {
            (FileCoefficients::Scalar(a), FileCoefficients::Scalar(b)) => a.product(b, order).into(),
            (a, b) => a.to_rgb().product(&b.to_rgb(), order).into(),
        };
        self.output.write(&ShFile::new(quantity, c))
    }
}

/// The quantity of a product, or the reason that it has none.
///
/// Visibility is a mask: what is masked stays what it is, another visibility too. Anything times a function of no quantity has
/// none either. Radiance times radiance and the like have units of their own, for which a file has no name: `--quantity` gives
/// one, such as `function`.
fn quantity_of_product(a: Quantity, b: Quantity) -> Result<Quantity, String> {
    match (a, b) {
        (Quantity::LogVisibility, _) | (_, Quantity::LogVisibility) => {
            Err("log-visibility is not multiplied; the logarithm of a product is a sum, so add them instead".to_owned())
        }
        (Quantity::Visibility, other) | (other, Quantity::Visibility) => Ok(other),
        (Quantity::Function, _) | (_, Quantity::Function) => Ok(Quantity::Function),
        (a, b) => Err(format!("{a} times {b} is no quantity of a file; expected visibility for one of them")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_keep_the_other_quantity_functions_have_none_and_logarithms_are_refused() {
        for a in Quantity::ALL {
            for b in Quantity::ALL {
                let found = quantity_of_product(a, b);
                let log = a == Quantity::LogVisibility || b == Quantity::LogVisibility;
                let free = [Quantity::Visibility, Quantity::Function];
                let free = free.contains(&a) || free.contains(&b);
                assert_eq!(found.is_ok(), !log && free, "{a} times {b}: {found:?}");
                assert_eq!(found.ok(), quantity_of_product(b, a).ok(), "{a} times {b} both ways");
            }
        }
        let masked = quantity_of_product(Quantity::Visibility, Quantity::Radiance);
        assert_eq!(masked, Ok(Quantity::Radiance), "masked radiance");
        let free = quantity_of_product(Quantity::Radiance, Quantity::Function);
        assert_eq!(free, Ok(Quantity::Function), "radiance times a function");
    }
}
