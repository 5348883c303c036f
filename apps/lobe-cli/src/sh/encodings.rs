//! `lobe sh encodings`: errors of compact encodings of the irradiance of an environment map.

use clap::Args;
use lobe::env::{EnvMap, irradiance_at, irradiance_sh};
use lobe::sh::{Dir, EncodingError, IrradianceEncoding, Rgb, ShVec, encoding_error, even_directions};
use serde::Serialize;

use crate::args::map_input::MapInput;
use crate::args::output;
use crate::run::talk::Talk;

/// The order of the irradiance that is encoded. Of a single lamp the bands left out have an RMS of 2.4 % of the mean
/// (that of the clamped cosine beyond band 10, 0.0059 of 1/4); they concern only what is sampled or fitted over a
/// hemisphere.
const ORDER: usize = 12;

/// Normals towards which the encodings are compared with the sum over all pixels.
const NORMALS: usize = 1024;

/// The steps of the progress bar, in each of which the picture is prepared for summing.
const STEPS: usize = 16;

#[derive(Args)]
pub(crate) struct ShEncodings {
    #[command(flatten)]
    input: MapInput,
    /// Print {"mean", "encodings": [{"name", "floats", "hemisphere", "mean", "rms", "max", "lowest"}]} instead of text; the
    /// errors in units of the mean irradiance, hemisphere tells which serve one side of a surface only
    #[arg(long)]
    json: bool,
}

/// The JSON of `--json`.
#[derive(Serialize)]
pub(crate) struct Measured {
    /// The mean irradiance of all channels over all normals.
    pub(crate) mean: f64,
    pub(crate) encodings: Vec<Row>,
}

/// One encoding.
#[derive(Serialize)]
pub(crate) struct Row {
    pub(crate) name: &'static str,
    pub(crate) floats: usize,
    pub(crate) hemisphere: bool,
    pub(crate) mean: f64,
    pub(crate) rms: f64,
    pub(crate) max: f64,
    pub(crate) lowest: f64,
}

impl ShEncodings {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let map = self.input.read_lat_long(talk)?;
        let bar = talk.bar("irradiance", NORMALS as u64);
        let measured = measure(&map, |normals| bar.inc(normals as u64));
        bar.finish_and_clear();
        if self.json {
            return output::print_json(&measured);
        }
        output::print(&text(&measured))
    }
}

/// The irradiance as it is given to the encodings.
pub(crate) fn irradiance_to_encode(map: &EnvMap) -> ShVec<Rgb<f64>> {
    irradiance_sh(map, ORDER)
}

/// Measures every encoding against the sum over all pixels; calls `progress` with numbers of normals done.
pub(crate) fn measure(map: &EnvMap, progress: impl Fn(usize)) -> Measured {
    let irradiance = irradiance_to_encode(map);
    let normals: Vec<Dir> = even_directions(NORMALS).collect();
    let mut truth = Vec::new();
    for normals in normals.chunks(NORMALS.div_ceil(STEPS)) {
        truth.extend(normals.iter().copied().zip(irradiance_at(map, normals)));
        progress(normals.len());
    }
    let mean = truth.iter().flat_map(|(_, e)| e.to_array()).sum::<f64>() / (3 * NORMALS) as f64;
    let row = |encoding: IrradianceEncoding| {
        let EncodingError { mean, rms, max, lowest } = encoding_error(encoding, &irradiance, &truth);
        let hemisphere = encoding.is_hemispherical();
        Row { name: encoding.name(), floats: encoding.floats(3), hemisphere, mean, rms, max, lowest }
    };
    Measured { mean, encodings: IrradianceEncoding::ALL.into_iter().map(row).collect() }
}

/// The table for people: errors in percent of the mean.
fn text(measured: &Measured) -> String {
    let mut text = format!("mean irradiance {:.4}; errors in percent of it\n\n", measured.mean);
    text += &format!("{:<30}{:>6}{:>9}{:>9}{:>9}{:>11}\n", "encoding", "floats", "mean", "RMS", "max", "lowest");
    for (k, row) in measured.encodings.iter().enumerate() {
        if row.hemisphere && k > 0 && !measured.encodings[k - 1].hemisphere {
            text += "\nfor the normals on one side of a surface:\n";
        }
        let [mean, rms, max] = [row.mean, row.rms, row.max].map(|x| format!("{:.2}", 100.0 * x));
        text += &format!("{:<30}{:>6}{mean:>9}{rms:>9}{max:>9}{:>11.4}\n", row.name, row.floats, row.lowest);
    }
    text
}
