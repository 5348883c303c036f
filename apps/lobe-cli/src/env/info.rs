//! `lobe env info`: facts about an environment map.

use clap::Args;
use lobe::env::{MappedMap, Nonfinite};
use lobe::sh::{Coefficient as _, Rgb};
use serde::Serialize;

use crate::args::map_input::MapPath;
use crate::args::output;
use crate::run::talk::Talk;

#[derive(Args)]
pub(crate) struct EnvInfo {
    #[command(flatten)]
    input: MapPath,
    /// Print {"format", "width", "height", "levels", "mapping", "mean", "min", "max", "nonfinite", "negative"} instead of text;
    /// mean (over the sphere), min and max are of the largest level and have one number per channel, the last two are counts of
    /// pixels
    #[arg(long)]
    json: bool,
}

/// The JSON of `--json`. Pixels that are NaN or infinite count as black.
#[derive(Serialize)]
struct Info {
    format: String,
    width: usize,
    height: usize,
    levels: usize,
    mapping: &'static str,
    mean: Rgb<f64>,
    min: Rgb<f32>,
    max: Rgb<f32>,
    nonfinite: usize,
    negative: usize,
}

impl EnvInfo {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let (levels, report) = self.input.read_with(Nonfinite::Zero, talk)?;
        let map = levels.base();
        let info = Info {
            format: report.picture.format.to_string(),
            width: map.width(),
            height: map.height(),
            levels: report.picture.levels,
            mapping: map.mapping().name(),
            mean: map.mean(),
            min: fold_channels(map, f32::INFINITY, f32::min),
            max: fold_channels(map, f32::NEG_INFINITY, f32::max),
            nonfinite: report.picture.nonfinite,
            negative: report.picture.negative,
        };
        if self.json {
            return output::print_json(&info);
        }
        let Info { format, width, height, levels, mapping, mean, min, max, nonfinite, negative } = info;
        // People need no more digits of the mean than of the pixels.
        let mean = Rgb::<f32>::narrow(mean);
        output::print(&format!(
            "format     {format}\nsize       {width} x {height}\nlevels     {levels}\nmapping    {mapping}\nmean       {:?} {:?} {:?}\n\
             min        {:?} {:?} {:?}\nmax        {:?} {:?} {:?}\nnonfinite  {nonfinite}\nnegative   {negative}\n",
            mean.r, mean.g, mean.b, min.r, min.g, min.b, max.r, max.g, max.b
        ))
    }
}

/// Folds every channel over all pixels.
fn fold_channels(map: &MappedMap, start: f32, f: fn(f32, f32) -> f32) -> Rgb<f32> {
    let fold = |a: Rgb<f32>, b: &Rgb<f32>| Rgb::new(f(a.r, b.r), f(a.g, b.g), f(a.b, b.b));
    map.texels().iter().fold(Rgb::new(start, start, start), fold)
}
