//! `lobe compress`: compression of transfer by clustered principal components, or to 16 bits.

use std::path::PathBuf;

use anyhow::{anyhow, bail};
use clap::Args;
use lobe::io::JobArgs;
use lobe::prt::{
    CompressOptions, CompressReport, CompressedTransfer, CompressionOptions, CurvePoint, HalfReport, HalfTransfer,
    Recipe, Transfer, error_curve, write_compressed_transfer, write_half_transfer,
};
use serde::Serialize;

use crate::args::output;
use crate::args::transfer_input::TransferInput;
use crate::run::bake_watch::{tell_if_too_late, watched};
use crate::run::talk::Talk;

/// The points of `--curve` besides those asked for: as in the paper, in fourfold and twofold steps.
const CURVE_CLUSTERS: [usize; 6] = [1, 4, 16, 64, 256, 1024];
const CURVE_COMPONENTS: [usize; 6] = [0, 1, 2, 4, 8, 16];

#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Args)]
pub(crate) struct Compress {
    #[command(flatten)]
    input: TransferInput,
    /// The compressed transfer, a .safetensors file
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    compression: JobArgs<CompressionOptions>,
    /// Keep all coefficients, in 16 bits each, instead of clusters and components
    #[arg(long, conflicts_with_all = ["clusters", "components", "weights", "curve"])]
    f16: bool,
    /// Print also the error with other numbers of clusters and components, up to these
    #[arg(long)]
    curve: bool,
    /// Print {"receivers", "clusters", "components", "squared_error", "relative_error", "bytes_before", "bytes", "ratio",
    /// "iterations"} on stdout, and "curve" with --curve; with --f16 {"receivers", "relative_error", "bytes_before", "bytes", "ratio"}
    #[arg(long)]
    json: bool,
}

/// The JSON of `--json`.
#[derive(Serialize)]
struct Printed<R: Serialize> {
    receivers: usize,
    #[serde(flatten)]
    report: R,
    #[serde(skip_serializing_if = "Option::is_none")]
    curve: Option<Vec<CurvePoint>>,
}

impl Compress {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        output::check_safetensors(&self.output)?;
        output::prepare_file(&self.output, &[self.input.path()])?;
        if self.f16 {
            let (transfer, recipe) = self.input.read(bytes_of_halves)?;
            return self.to_halves(&transfer, recipe, talk);
        }
        let (transfer, recipe) = self.input.read(bytes_of_work)?;
        let options = self.compression.job()?.of_transfer();
        let compressed = watched(talk, "compress", |job| CompressedTransfer::new(&transfer, &options, job))?;
        let Ok((compressed, report)) = compressed else {
            bail!("stopped; nothing is written, and the same command starts anew")
        };
        write_compressed_transfer(&self.output, &compressed, &recipe.of_compressed(&options, &report))?;
        tell_if_too_late(&self.output, talk);
        let curve = if self.curve { Some(self.curve_of(&transfer, &options, talk)?) } else { None };
        if self.json {
            output::print_json(&Printed { receivers: transfer.receivers(), report: &report, curve })
        } else {
            output::print(&text(&report, curve.as_deref()))
        }
    }

    fn to_halves(&self, transfer: &Transfer, recipe: Recipe, talk: Talk) -> anyhow::Result<()> {
        let (halves, report) =
            HalfTransfer::new(transfer).map_err(|error| anyhow!("{}: {error}", self.input.path().display()))?;
        write_half_transfer(&self.output, &halves, &recipe.of_halves(&report))?;
        tell_if_too_late(&self.output, talk);
        if self.json {
            return output::print_json(&Printed { receivers: transfer.receivers(), report, curve: None });
        }
        let HalfReport { relative_error, bytes, bytes_before, .. } = report;
        output::print(&format!("relative error  {relative_error:.3e}\nbytes           {bytes} of {bytes_before}\n"))
    }

    fn curve_of(&self, transfer: &Transfer, options: &CompressOptions, talk: Talk) -> anyhow::Result<Vec<CurvePoint>> {
        let up_to = |steps: &[usize], most: usize| {
            let below = steps.iter().copied().filter(|n| *n < most);
            below.chain([most]).collect::<Vec<usize>>()
        };
        let clusters = up_to(&CURVE_CLUSTERS, options.clusters);
        let components = up_to(&CURVE_COMPONENTS, options.components);
        let points = watched(talk, "curve", |job| error_curve(transfer, &clusters, &components, options, job))?;
        points.or_else(|_| bail!("stopped before the curve was complete; {} is written", self.output.display()))
    }
}

/// Bytes of the work in memory: three and a half times those of the transfer, and 104 for each receiver; 2.8 and 104 were measured.
fn bytes_of_work(transfer: &Transfer) -> usize {
    7 * size_of_val(transfer.coefficients()) / 2 + 104 * transfer.receivers()
}

/// The same where transfer becomes one of 16 bits.
fn bytes_of_halves(transfer: &Transfer) -> usize {
    3 * size_of_val(transfer.coefficients()) / 2
}

fn text(report: &CompressReport, curve: Option<&[CurvePoint]>) -> String {
    let mut text = format!(
        "clusters        {}\ncomponents      {}\nrelative error  {:.3e}\nbytes           {} of {}, {:.1} times fewer\n",
        report.clusters, report.components, report.relative_error, report.bytes, report.bytes_before, report.ratio
    );
    if let Some(points) = curve {
        text += "\nclusters  components  relative error  bytes\n";
        for p in points {
            text += &format!("{:8}  {:10}  {:14.3e}  {}\n", p.clusters, p.components, p.relative_error, p.bytes);
        }
    }
    text
}
