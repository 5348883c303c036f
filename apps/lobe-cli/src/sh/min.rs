//! `lobe sh min`: the global minimum of an expansion over the sphere, with proven bounds.

use std::fmt::Write as _;

use anyhow::bail;
use clap::Args;
use lobe::sh::extrema::{Extremum, certified_minimum};
use lobe::sh::ringing::conservative_minimum;
use lobe::sh::sh_json::FileCoefficients;
use lobe::sh::{Coefficient, Expansion as _, ShVec};
use serde::Serialize;

use crate::args::input::ShInput;
use crate::args::output;
use crate::args::values;
use crate::run::talk::Talk;

#[derive(Args)]
pub(crate) struct ShMin {
    /// The expansion, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// The width of the interval that is proven to hold the least value, as a part of the root mean square
    #[arg(long, value_name = "X", default_value = "1e-6", allow_hyphen_values = true, value_parser = values::positive)]
    tolerance: f64,
    /// Only the closed bound of Sloan 2017, below which no value of up to three bands lies, as his dering has it
    #[arg(long, conflicts_with = "tolerance")]
    bound: bool,
    /// Print {"channels": [{"min", "lo", "hi", "dir"}]} instead of lines: no value is below lo, and the value towards
    /// dir is min, at most hi; with --bound {"channels": [{"bound"}]}
    #[arg(long)]
    json: bool,
}

/// A channel of the JSON of `--json`.
#[derive(Serialize)]
struct Channel {
    min: f64,
    lo: f64,
    hi: f64,
    dir: [f64; 3],
}

/// A channel of the JSON of `--bound --json`.
#[derive(Serialize)]
struct Bound {
    bound: f64,
}

/// The bands that the closed bound is for.
const BOUND_BANDS: usize = 3;

fn channel_names(count: usize) -> &'static [&'static str] {
    if count == 1 { &["least"] } else { &["red", "green", "blue"] }
}

impl ShMin {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let file = if self.bound { self.input.read()? } else { self.input.read_to_search()? };
        if self.bound {
            return match file.coefficients {
                FileCoefficients::Scalar(f) => self.print_bounds(&f),
                FileCoefficients::Rgb(f) => self.print_bounds(&f),
            };
        }
        let minima = talk.while_waiting("search", || match &file.coefficients {
            FileCoefficients::Scalar(f) => self.find(f),
            FileCoefficients::Rgb(f) => self.find(f),
        });
        if self.json { output::print_json_list("channels", minima) } else { output::print(&text(&minima)) }
    }

    fn print_bounds<T: Coefficient<Scalar = f64>>(&self, f: &ShVec<T>) -> anyhow::Result<()> {
        if f.order() > BOUND_BANDS {
            bail!("{}: --bound: expected up to three bands, found order {}; leave --bound out", self.input, f.order());
        }
        let bound = |c: usize| conservative_minimum(f.map(|value| value.channel(c)).coefficients());
        let bounds: Vec<f64> = (0..T::CHANNELS).map(bound).collect();
        if self.json {
            return output::print_json_list("channels", bounds.into_iter().map(|bound| Bound { bound }).collect());
        }
        let line = |(name, bound): (&&str, &f64)| format!("{name} {bound:?} or above, by the closed bound\n");
        output::print(&channel_names(bounds.len()).iter().zip(&bounds).map(line).collect::<String>())
    }

    fn find<T: Coefficient<Scalar = f64>>(&self, f: &ShVec<T>) -> Vec<Channel> {
        let channel = |c: usize| {
            let channel = f.map(|value| value.channel(c));
            let Extremum { lo, hi, dir } = certified_minimum(channel.coefficients(), self.tolerance);
            // The interval allows for more rounding than this one sum has.
            Channel { min: channel.eval(dir).clamp(lo, hi), lo, hi, dir: dir.to_array() }
        };
        (0..T::CHANNELS).map(channel).collect()
    }
}

fn text(channels: &[Channel]) -> String {
    let mut text = String::new();
    for (name, Channel { min, lo, dir: [x, y, z], .. }) in channel_names(channels.len()).iter().zip(channels) {
        let below = min - lo;
        let _ =
            writeln!(text, "{name} {min:?} towards {x:.6} {y:.6} {z:.6}, proven: nothing more than {below:.1e} below");
    }
    text
}
