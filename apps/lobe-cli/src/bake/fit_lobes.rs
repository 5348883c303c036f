//! `lobe fit-lobes`: a fit of zonal lobes to transfer, for surfaces that bend.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use lobe::prt::{Transfer, ZonalFitOptions, ZonalTransfer, fit_zonal, write_zonal_transfer};
use serde::Serialize;

use crate::args::output;
use crate::args::transfer_input::TransferInput;
use crate::args::values;
use crate::run::bake_watch::{tell_if_too_late, watched};
use crate::run::talk::Talk;

#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Args)]
pub(crate) struct FitLobes {
    #[command(flatten)]
    input: TransferInput,
    /// The lobes, a .safetensors file
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Lobes of each vertex, 1 to 8
    #[arg(long, value_name = "N", default_value = "1", value_parser = lobes)]
    lobes: usize,
    /// Take the closed form: the axis of a single lobe is the optimal linear direction
    #[arg(long)]
    closed_form: bool,
    /// Print {"receivers", "lobes", "squared_error", "relative_error", "worst_relative_error", "bytes"} on stdout
    #[arg(long)]
    json: bool,
}

fn lobes(text: &str) -> Result<usize, String> {
    values::whole(text, 1, ZonalTransfer::MAX_LOBES, "a number of lobes")
}

/// The JSON of `--json`.
#[derive(Serialize)]
struct Printed {
    receivers: usize,
    lobes: usize,
    squared_error: f64,
    relative_error: f64,
    worst_relative_error: f64,
    bytes: usize,
}

impl FitLobes {
    /// Bytes of the work in memory: twice the transfer, the lobes, and 56 for each receiver, as was measured.
    fn bytes_of_work(&self, transfer: &Transfer) -> usize {
        let of_lobe = 3 + transfer.channels().count() * transfer.order();
        2 * size_of_val(transfer.coefficients()) + transfer.receivers() * (4 * self.lobes * of_lobe + 56)
    }

    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        output::check_safetensors(&self.output)?;
        output::prepare_file(&self.output, &[self.input.path()])?;
        let (transfer, recipe) = self.input.read(|transfer| self.bytes_of_work(transfer))?;
        let options = ZonalFitOptions::default().lobes(self.lobes).optimize(!self.closed_form);
        let fitted = watched(talk, "fit", |job| fit_zonal(&transfer, &options, job))?;
        let Ok((zonal, report)) = fitted else {
            bail!("stopped; nothing is written, and the same command starts anew")
        };
        let recipe = recipe
            .lobes(self.lobes)
            .closed_form(self.closed_form)
            .relative_error(report.relative_error)
            .fitted_by(env!("CARGO_PKG_VERSION").to_owned());
        write_zonal_transfer(&self.output, &zonal, &recipe)?;
        tell_if_too_late(&self.output, talk);
        let printed = Printed {
            receivers: zonal.receivers(),
            lobes: zonal.lobes(),
            squared_error: report.squared_error,
            relative_error: report.relative_error,
            worst_relative_error: report.worst_relative_error,
            bytes: zonal.bytes(),
        };
        if self.json { output::print_json(&printed) } else { output::print(&printed.to_text()) }
    }
}

impl Printed {
    fn to_text(&self) -> String {
        format!(
            "receivers       {}\nlobes           {}\nrelative error  {:.3e}, at worst {:.3e}\nbytes           {}\n",
            self.receivers, self.lobes, self.relative_error, self.worst_relative_error, self.bytes
        )
    }
}
