//! `lobe sh mirror`: reflection of an expansion along an axis.

use clap::Args;
use lobe::sh::Expansion as _;
use lobe::sh::rotation::{Axis, mirror_in_place};
use lobe::sh::sh_json::{FileCoefficients, ShFile};

use crate::args::input::ShInput;
use crate::args::names::names;
use crate::args::output::ShOutput;

#[derive(Args)]
pub(crate) struct ShMirror {
    /// The expansion, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// The axis that changes its sign: x exchanges +x and -x
    #[arg(long, value_enum)]
    axis: AxisName,
    /// The mirrored expansion, a .sh.json file; - writes to stdout
    #[arg(short, long, value_name = "Q")]
    output: ShOutput,
}

names! {
    enum AxisName for Axis {
        X,
        Y,
        Z,
    }
}

impl ShMirror {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        self.output.check()?;
        let ShFile { quantity, mut coefficients } = self.input.read()?;
        let axis = self.axis.into();
        match &mut coefficients {
            FileCoefficients::Scalar(f) => mirror_in_place(f.coefficients_mut(), axis),
            FileCoefficients::Rgb(f) => mirror_in_place(f.coefficients_mut(), axis),
        }
        self.output.write(&ShFile::new(quantity, coefficients))
    }
}
