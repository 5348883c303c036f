//! `lobe sh encodings`: errors of compact encodings of the irradiance of an environment map.

use clap::Args;
use lobe::env::{EncodingErrors, encoding_errors};
use lobe::sh::encoding::{EncodingError, IrradianceEncoding};
use serde::Serialize;

use crate::args::map_input::MapInput;
use crate::args::output;
use crate::run::talk::Talk;

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
struct Measured {
    mean: f64,
    encodings: Vec<Row>,
}

/// One encoding.
#[derive(Serialize)]
struct Row {
    name: &'static str,
    floats: usize,
    hemisphere: bool,
    mean: f64,
    rms: f64,
    max: f64,
    lowest: f64,
}

impl ShEncodings {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let map = self.input.read_lat_long(talk)?;
        let EncodingErrors { mean, encodings, .. } = talk.watch("irradiance", |job| encoding_errors(&map, job))?;
        let row = |(encoding, error): (IrradianceEncoding, EncodingError)| {
            let EncodingError { mean, rms, max, lowest } = error;
            let (name, hemisphere) = (encoding.name(), encoding.is_hemispherical());
            Row { name, floats: encoding.floats(3), hemisphere, mean, rms, max, lowest }
        };
        let measured = Measured { mean, encodings: encodings.into_iter().map(row).collect() };
        if self.json {
            return output::print_json(&measured);
        }
        output::print(&text(&measured))
    }
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
