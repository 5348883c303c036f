//! `lobe sh info`: order, range of values and band energies of an expansion.

use clap::Args;
use lobe::sh::sh_json::FileCoefficients;
use lobe::sh::{Coefficient, Dir, Expansion, ShVec};
use serde::Serialize;

use crate::args::input::ShInput;
use crate::args::output;

/// Directions in which the least and the greatest value are looked for: a lat-long grid of twice as many columns as
/// rows, with the poles. A lobe of order 6 is some ten steps wide.
const ROWS: usize = 64;

/// A band this much smaller than the mean is rounding.
const NOTHING: f64 = 1e-12;

#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Args)]
pub(crate) struct ShInfo {
    /// The expansion, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// Print {"order", "quantity", "channels", "mean", "min", "max", "band_energy", "dir"} instead of text: one number per
    /// channel, or one row of them; min and max are those of 64 x 128 directions; band_energy has the sum of the squares of
    /// the coefficients in each band; dir is where band 1 points, null where it is nothing
    #[arg(long)]
    json: bool,
}

/// The JSON of `--json`: one entry for each channel.
#[derive(Debug, Serialize)]
struct Info {
    order: usize,
    quantity: String,
    channels: usize,
    mean: Vec<f64>,
    min: Vec<f64>,
    max: Vec<f64>,
    band_energy: Vec<Vec<f64>>,
    dir: Vec<Option<[f64; 3]>>,
}

impl ShInfo {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let file = self.input.read()?;
        let quantity = file.quantity.to_string();
        let info = match &file.coefficients {
            FileCoefficients::Scalar(f) => Info::new(f, quantity),
            FileCoefficients::Rgb(f) => Info::new(f, quantity),
        };
        if self.json { output::print_json(&info) } else { output::print(&info.to_text()) }
    }
}

impl Info {
    fn new<T: Coefficient<Scalar = f64>>(f: &ShVec<T>, quantity: String) -> Self {
        let channels = |value: T| (0..T::CHANNELS).map(|c| value.channel(c)).collect::<Vec<_>>();
        let mean = channels(f.mean());
        let mut min = vec![f64::INFINITY; T::CHANNELS];
        let mut max = vec![f64::NEG_INFINITY; T::CHANNELS];
        for s in grid() {
            for (c, value) in channels(f.eval(s)).into_iter().enumerate() {
                min[c] = min[c].min(value);
                max[c] = max[c].max(value);
            }
        }
        let energies: Vec<Vec<f64>> = f.band_energies().into_iter().map(channels).collect();
        let band_energy = (0..T::CHANNELS).map(|c| energies.iter().map(|band| band[c]).collect()).collect();
        let dir = (0..T::CHANNELS).map(|c| towards(f, c)).collect();
        Self { order: f.order(), quantity, channels: T::CHANNELS, mean, min, max, band_energy, dir }
    }

    fn to_text(&self) -> String {
        let Self { order, quantity, channels, .. } = self;
        let mut text = format!("order     {order}\nquantity  {quantity}\nchannels  {channels}\n");
        for (name, values) in [("mean", &self.mean), ("min", &self.min), ("max", &self.max)] {
            text += &format!("{name:8}  {}\n", numbers(values));
        }
        for l in 0..*order {
            let energy: Vec<f64> = self.band_energy.iter().map(|bands| bands[l]).collect();
            text += &format!("{:8}  {}\n", format!("band {l}"), numbers(&energy));
        }
        let names: &[&str] = if self.channels == 1 { &["points"] } else { &["red", "green", "blue"] };
        for (name, dir) in names.iter().zip(&self.dir) {
            let dir = dir.map_or("nowhere".to_owned(), |dir| numbers(&dir));
            text += &format!("{name:8}  towards {dir}\n");
        }
        text
    }
}

/// The direction in which band 1 of a channel is largest: `(f_1, f_-1, f_0)` in Condon-Shortley's signs; none if it is
/// nothing.
fn towards<T: Coefficient<Scalar = f64>>(f: &ShVec<T>, channel: usize) -> Option<[f64; 3]> {
    if f.order() < 2 {
        return None;
    }
    let [y, z, x] = [0, 1, 2].map(|i| f.band(1)[i].channel(channel));
    let size = x.hypot(y).hypot(z);
    let mean = f.band(0)[0].channel(channel).abs();
    if size <= NOTHING * mean {
        return None;
    }
    Dir::new([-x, -y, z]).map(Dir::to_array)
}

/// The directions of a lat-long grid and the poles.
fn grid() -> impl Iterator<Item = Dir> {
    let step = std::f64::consts::PI / ROWS as f64;
    let row =
        move |y: usize| (0..2 * ROWS).map(move |x| Dir::from_angles((y as f64 + 0.5) * step, (x as f64 + 0.5) * step));
    (0..ROWS).flat_map(row).chain([Dir::Z, -Dir::Z])
}

/// As many digits as a picture has.
fn numbers(values: &[f64]) -> String {
    values.iter().map(|x| format!("{:?}", *x as f32)).collect::<Vec<_>>().join(" ")
}
