//! `lobe sh rotate`: rotation of an expansion.

use clap::Args;
use lobe::sh::sh_json::{FileCoefficients, ShFile};

use crate::args::input::ShInput;
use crate::args::output::ShOutput;
use crate::args::turn::Turn;

#[derive(Args)]
pub(crate) struct ShRotate {
    /// The expansion, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    #[command(flatten)]
    turn: Turn,
    /// The turned expansion g(s) = f(R⁻¹ s), a .sh.json file; - writes to stdout
    #[arg(short, long, value_name = "Q")]
    output: ShOutput,
}

impl ShRotate {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let rotation = self.turn.rotation()?;
        self.output.check()?;
        let ShFile { quantity, coefficients } = self.input.read()?;
        let turned: FileCoefficients = match coefficients {
            FileCoefficients::Scalar(f) => f.rotated(&rotation).into(),
            FileCoefficients::Rgb(f) => f.rotated(&rotation).into(),
        };
        self.output.write(&ShFile::new(quantity, turned))
    }
}
