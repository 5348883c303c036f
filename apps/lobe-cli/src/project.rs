//! `lobe project`: projection of an environment map onto spherical harmonics.

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::env::MappedMap;
use lobe::sh::expansion::Quantity;
use lobe::sh::projection::{MonteCarloOptions, Sampling, project_monte_carlo};
use lobe::sh::sh_json::ShFile;
use lobe::sh::{Coefficient as _, Expansion as _, Rgb, ShVec};

use crate::args::map_input::MapInput;
use crate::args::output::ShOutput;
use crate::args::values;
use crate::run::talk::Talk;

/// Days of work on any machine. A larger number is taken for a typing error.
const MAX_SAMPLES: usize = 1_000_000_000;

#[derive(Args)]
pub(crate) struct Project {
    #[command(flatten)]
    input: MapInput,
    /// The expansion of its radiance, or of what --quantity says that its pixels are, a .sh.json file; - writes to stdout
    #[arg(short, long, value_name = "P")]
    output: ShOutput,
    /// The order (number of bands), 1 to 256: n² coefficients
    #[arg(long, value_name = "N", default_value = "3", value_parser = values::order)]
    order: usize,
    /// The method of integration
    #[arg(long, value_enum, default_value = "exact")]
    method: Method,
    /// The number of directions to look in, for monte-carlo (rounded down to a square) and fibonacci (which takes half as many again to estimate its error) [default: 10000]
    #[arg(long, value_name = "N", value_parser = samples)]
    samples: Option<usize>,
    /// For monte-carlo: the same seed gives the same directions [default: 0]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// The quantity that the pixels are: radiance, irradiance, transfer, visibility, log-visibility or function, which is none of
    /// them
    #[arg(long, value_name = "QUANTITY", default_value = "radiance", value_parser = str::parse::<Quantity>)]
    quantity: Quantity,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Method {
    /// Integrate the basis over every pixel
    Exact,
    /// Look in one random direction in each cell of a grid, and estimate the error
    MonteCarlo,
    /// Look in the directions of a Fibonacci spiral, and estimate the error
    Fibonacci,
}

fn samples(text: &str) -> Result<usize, String> {
    values::whole(text, 1, MAX_SAMPLES, "a number of samples")
}

impl Project {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.check_options()?;
        self.output.check()?;
        let f = match self.method {
            Method::Exact => self.input.project(self.order, talk)?,
            Method::MonteCarlo => self.project_by_sampling(&self.input.read(talk)?, Sampling::Jittered, talk),
            Method::Fibonacci => self.project_by_sampling(&self.input.read(talk)?, Sampling::Fibonacci, talk),
        };
        self.output.write(&ShFile::new(self.quantity, f))
    }

    /// Refuses options that would be ignored.
    fn check_options(&self) -> anyhow::Result<()> {
        if self.samples.is_some() && self.method == Method::Exact {
            bail!(
                "--samples: every pixel counts with --method exact; choose monte-carlo or fibonacci, or leave it out"
            );
        }
        if self.seed.is_some() && self.method != Method::MonteCarlo {
            bail!("--seed: only --method monte-carlo is random; choose it, or leave the seed out");
        }
        Ok(())
    }

    fn project_by_sampling(&self, map: &MappedMap, sampling: Sampling, talk: Talk) -> ShVec<Rgb<f64>> {
        let defaults = MonteCarloOptions::default();
        let options = MonteCarloOptions::default()
            .samples(self.samples.unwrap_or(defaults.samples))
            .seed(self.seed.unwrap_or(defaults.seed))
            .sampling(sampling);
        let estimate = project_monte_carlo(self.order, &options, |s| map.radiance(s).widen());
        let text = format!(
            "{} directions; standard error of a coefficient {:.1e} at most, largest coefficient {:.1e}",
            estimate.evaluations,
            largest_channel(&estimate.standard_error),
            largest_channel(&estimate.sh)
        );
        talk.note(&self.input.name(), &text);
        estimate.sh
    }
}

/// The largest magnitude of any channel of any coefficient.
fn largest_channel(f: &ShVec<Rgb<f64>>) -> f64 {
    f.coefficients().iter().flat_map(|c| c.to_array()).fold(0.0, |largest, c| largest.max(c.abs()))
}
