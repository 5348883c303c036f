//! `lobe sh dering`: deringing, an expansion made non-negative with little change.

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::sh::expansion::Quantity;
use lobe::sh::extrema::Extremum;
use lobe::sh::ringing::{DeringMethod, DeringOptions, DeringOutcome, DeringReport};
use lobe::sh::sh_json::{FileCoefficients, ShFile};
use lobe::sh::{Coefficient, Expansion as _, ShError, ShVec, Zonal};
use serde::Serialize;

use crate::args::input::ShInput;
use crate::args::output::{self, ShOutput};
use crate::run::talk::Talk;

const JSON_HELP: &str = r#"Print {"min_before", "min_after", "bands", "energy_removed", "excess"}: what no value of each channel is below, the factors of the bands, the part of the energy that was lost, by how much the change exceeds the least one at most (least-change)"#;

#[derive(Args)]
pub(crate) struct ShDering {
    /// The expansion, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// The quantity that becomes non-negative: that of P, or the irradiance of P, if that is radiance [default: that of P]
    #[arg(long, value_enum)]
    quantity: Option<Wanted>,
    /// least-change: a factor for each band, such that the norm of the change is least; table: the search of Sloan 2017, for
    /// three bands; the others: the weakest window of that family (sinc4 is lanczos:4)
    #[arg(
        long,
        value_name = "least-change|table|hanning|lanczos[:POWER]|sinc4|gauss|laplacian",
        default_value = "least-change",
        value_parser = method
    )]
    method: DeringMethod,
    /// The non-negative expansion, a .sh.json file; - writes to stdout
    #[arg(short, long, value_name = "Q")]
    output: ShOutput,
    #[arg(long, help = JSON_HELP)]
    json: bool,
}

/// The bands that the table is for.
const TABLE_BANDS: usize = 3;

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Wanted {
    /// What diffuse surfaces receive
    Irradiance,
    /// The light itself
    Radiance,
}

/// The library's names and the short ones of `lobe sh window`.
fn method(text: &str) -> Result<DeringMethod, String> {
    let name = match text {
        "sinc4" => "lanczos:4",
        "laplacian" => "squared-laplacian",
        text => text,
    };
    name.parse().map_err(|error: ShError| error.to_string())
}

/// The JSON of `--json`.
#[derive(Serialize)]
struct Report<'a> {
    min_before: Vec<f64>,
    min_after: Vec<f64>,
    bands: &'a [f64],
    energy_removed: f64,
    excess: Option<f64>,
}

impl ShDering {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        if self.json && self.output == ShOutput::Stdout {
            bail!("stdout: both the expansion and the JSON would go there; name a file for -o, or leave --json out");
        }
        self.output.check()?;
        let file = self.input.read_to_search()?;
        let dering = DeringOptions::default().method(self.method).kernel(self.kernel(&file)?);
        let (coefficients, report) = talk.while_waiting("dering", || match &file.coefficients {
            FileCoefficients::Scalar(f) => self.deringed(f, &dering),
            FileCoefficients::Rgb(f) => self.deringed(f, &dering),
        })?;
        self.output.write(&ShFile::new(file.quantity, coefficients))?;
        if self.json {
            return output::print_json(&Report {
                min_before: lower_ends(&report.before),
                min_after: lower_ends(&report.after),
                bands: &report.factors,
                energy_removed: report.energy_removed,
                excess: report.excess,
            });
        }
        talk.note(&self.input.to_string(), &in_words(&report));
        Ok(())
    }

    /// The kernel with which the expansion in the file is convolved before its values are examined.
    fn kernel(&self, file: &ShFile) -> anyhow::Result<Option<Zonal>> {
        match (self.quantity, file.quantity) {
            (_, Quantity::LogVisibility) => {
                bail!("{}: {} is negative by its nature; expected any other quantity", self.input, file.quantity)
            }
            (Some(Wanted::Irradiance), Quantity::Radiance) => {
                Ok(Some(Zonal::clamped_cosine(file.coefficients.order())))
            }
            (None, _)
            | (Some(Wanted::Irradiance), Quantity::Irradiance)
            | (Some(Wanted::Radiance), Quantity::Radiance) => Ok(None),
            (Some(Wanted::Irradiance), found) => {
                bail!("{}: --quantity irradiance: expected radiance or irradiance, found {found}", self.input)
            }
            (Some(Wanted::Radiance), found) => {
                bail!("{}: --quantity radiance: expected radiance, found {found}", self.input)
            }
        }
    }

    fn deringed<T: Coefficient>(
        &self,
        f: &ShVec<T>,
        dering: &DeringOptions,
    ) -> anyhow::Result<(FileCoefficients, DeringReport)>
    where
        ShVec<T>: Into<FileCoefficients>,
    {
        let (g, report) = f.deringed_with(dering);
        match report.outcome {
            DeringOutcome::Unchanged | DeringOutcome::Windowed => Ok((g.into(), report)),
            DeringOutcome::MeanNotPositive { channel } => {
                let mean = f.mean().channel(channel);
                let which = if T::CHANNELS == 1 { "" } else { [" of red", " of green", " of blue"][channel.min(2)] };
                bail!(
                    "{}: the mean{which} is {mean:?}; expected one above 0, or no window makes it non-negative",
                    self.input
                )
            }
            DeringOutcome::BeyondTable if f.order() > TABLE_BANDS => bail!(
                "{}: --method table: expected light of up to three bands, found order {}; choose least-change",
                self.input,
                f.order()
            ),
            DeringOutcome::BeyondTable => bail!(
                "{}: --method table: expected irradiance, which its strongest window suffices for, found a function that \
                 rings more; choose least-change",
                self.input
            ),
            _ => bail!("{}: expected finite coefficients", self.input),
        }
    }
}

/// The lower bound of each channel.
fn lower_ends(minima: &[Extremum]) -> Vec<f64> {
    minima.iter().map(|min| min.lo).collect()
}

fn in_words(report: &DeringReport) -> String {
    if report.outcome == DeringOutcome::Unchanged {
        return "nowhere negative, left as it is".to_owned();
    }
    let least = |minima: &[Extremum]| minima.iter().map(|min| min.lo).fold(f64::INFINITY, f64::min);
    let bands = report.factors.iter().map(|w| format!("{w:.4}")).collect::<Vec<_>>().join(" ");
    format!(
        "least value {:.3e} before, {:.3e} after; bands {bands}; {:.2} % of the energy removed",
        least(&report.before),
        least(&report.after),
        100.0 * report.energy_removed
    )
}
