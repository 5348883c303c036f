//! `lobe sh min`: the least value of an expansion over the sphere, with proof.

use std::fmt::Write as _;

use clap::Args;
use lobe::sh::{Coefficient, Expansion as _, FileCoefficients, Minimum, ShVec, certified_minimum};
use serde::Serialize;

use crate::input::ShInput;
use crate::{output, values};

#[derive(Args)]
pub(crate) struct ShMin {
    /// The expansion, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// The width of the interval that is proven to hold the least value, as a part of the root mean square
    #[arg(long, value_name = "X", default_value = "1e-6", allow_hyphen_values = true, value_parser = values::positive)]
    tolerance: f64,
    /// Print {"channels": [{"min", "lo", "hi", "dir"}]} instead of lines: no value is below lo, and the value towards dir is
    /// min, at most hi
    #[arg(long)]
    json: bool,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Minima {
    channels: Vec<Channel>,
}

#[derive(Serialize)]
struct Channel {
    min: f64,
    lo: f64,
    hi: f64,
    dir: [f64; 3],
}

impl ShMin {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let minima = match self.input.read()?.coefficients {
            FileCoefficients::Scalar(f) => self.find(&f),
            FileCoefficients::Rgb(f) => self.find(&f),
        };
        if self.json { output::print_json(&minima) } else { output::print(&minima.text()) }
    }

    fn find<T: Coefficient<Scalar = f64>>(&self, f: &ShVec<T>) -> Minima {
        let channel = |c: usize| {
            let channel = f.map(|value| value.channel(c));
            let Minimum { lo, hi, dir } = certified_minimum(channel.coefficients(), self.tolerance);
            // The interval allows for more rounding than this one sum has.
            Channel { min: channel.eval(dir).clamp(lo, hi), lo, hi, dir: dir.to_array() }
        };
        Minima { channels: (0..T::CHANNELS).map(channel).collect() }
    }
}

impl Minima {
    fn text(&self) -> String {
        let mut text = String::new();
        let names: &[&str] = if self.channels.len() == 1 { &["least"] } else { &["red", "green", "blue"] };
        for (name, Channel { min, lo, dir: [x, y, z], .. }) in names.iter().zip(&self.channels) {
            let below = min - lo;
            let _ = writeln!(
                text,
                "{name} {min:?} towards {x:.6} {y:.6} {z:.6}, proven: nothing more than {below:.1e} below"
            );
        }
        text
    }
}
