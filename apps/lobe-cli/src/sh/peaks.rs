//! `lobe sh peaks`: all local maxima of an expansion.

use clap::Args;
use lobe::sh::Rgb;
use lobe::sh::light_extraction::{Peak, PeakSearch, local_maxima};
use lobe::sh::sh_json::FileCoefficients;
use serde::Serialize;

use crate::args::input::ShInput;
use crate::args::names::names;
use crate::args::output;
use crate::run::talk::Talk;

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

/// A maximum in the JSON of `--json`.
#[derive(Serialize)]
struct Found {
    dir: [f64; 3],
    value: f64,
}

impl ShPeaks {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let f = match self.input.read_to_search()?.coefficients {
            FileCoefficients::Scalar(f) => f,
            FileCoefficients::Rgb(f) => f.map(Rgb::luminance),
        };
        let found = |Peak { dir, value }: Peak| Found { dir: dir.to_array(), value };
        let maxima = talk.while_waiting("search", || local_maxima(&f, self.search.into()));
        let peaks: Vec<Found> = maxima.into_iter().map(found).collect();
        if self.json { output::print_json_list("peaks", peaks) } else { output::print(&text(&peaks)) }
    }
}

fn text(peaks: &[Found]) -> String {
    if peaks.is_empty() {
        return "no maximum: the same value everywhere\n".to_owned();
    }
    let line = |Found { dir: [x, y, z], value }: &Found| format!("{value:?} towards {x:.6} {y:.6} {z:.6}\n");
    peaks.iter().map(line).collect()
}
