//! `lobe sh peaks`: all local maxima of an expansion.

use std::fmt::Write as _;

use clap::Args;
use lobe::sh::{FileCoefficients, Peak, PeakSearch, Rgb, local_maxima};
use serde::Serialize;

use crate::args::input::ShInput;
use crate::args::names::names;
use crate::args::output;

#[derive(Args)]
pub(crate) struct ShPeaks {
    /// The expansion, a .sh.json file; - reads stdin; of colors the luminance is looked at
    #[arg(value_name = "P")]
    input: ShInput,
    /// The starting points of the search
    #[arg(long, value_enum, default_value = "grid")]
    search: Search,
    /// Print {"peaks": [{"dir", "value"}]} instead of lines, the highest first
    #[arg(long)]
    json: bool,
}

names! {
    enum Search for PeakSearch {
        /// At the high points of a fine grid, which finds all
        Grid,
        /// At the few points of Sloan 2008, up to order 6: faster, misses fewer than 1 %
        Paper,
    }
}

/// The JSON of `--json`.
#[derive(Serialize)]
struct Peaks {
    peaks: Vec<Found>,
}

#[derive(Serialize)]
struct Found {
    dir: [f64; 3],
    value: f64,
}

impl ShPeaks {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let f = match self.input.read()?.coefficients {
            FileCoefficients::Scalar(f) => f,
            FileCoefficients::Rgb(f) => f.map(Rgb::luminance),
        };
        let found = |Peak { dir, value }: Peak| Found { dir: dir.to_array(), value };
        let peaks = Peaks { peaks: local_maxima(&f, self.search.into()).into_iter().map(found).collect() };
        if self.json { output::print_json(&peaks) } else { output::print(&peaks.text()) }
    }
}

impl Peaks {
    fn text(&self) -> String {
        let mut text = String::new();
        for Found { dir: [x, y, z], value } in &self.peaks {
            let _ = writeln!(text, "{value:?} towards {x:.6} {y:.6} {z:.6}");
        }
        if self.peaks.is_empty() {
            text += "no maximum: the same value everywhere\n";
        }
        text
    }
}
