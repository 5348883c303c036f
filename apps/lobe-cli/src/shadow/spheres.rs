//! `lobe spheres`: few spheres that stand for a mesh; and `lobe spheres table`: the logarithms that their shadows look up.

use std::path::PathBuf;

use anyhow::bail;
use clap::{ArgMatches, Args, Command, FromArgMatches};
use lobe::shadow::{LogTable, LogTableOptions, SphereFitMethod, SphereJob, write_log_table};

use crate::args::asked_job::AskedJob;
use crate::args::output;
use crate::args::values;
use crate::run::bake_watch::tell_if_too_late;
use crate::run::job_watch::{Kept, watched_job};
use crate::run::talk::Talk;

/// `lobe spheres SCENE`, or `lobe spheres table`. What the first requires is not asked of the second.
pub(crate) enum SpheresCommand {
    Fit(Box<Spheres>),
    Table(SphereTable),
}

/// The name of the second.
const TABLE: &str = "table";

impl FromArgMatches for SpheresCommand {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        match matches.subcommand_matches(TABLE) {
            Some(matches) => SphereTable::from_arg_matches(matches).map(Self::Table),
            None => Spheres::from_arg_matches(matches).map(|fit| Self::Fit(Box::new(fit))),
        }
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for SpheresCommand {
    fn augment_args(command: Command) -> Command {
        let about =
            "Write the table of what single spheres hide, as logarithms, which lobe render --sphere-table looks up";
        let table = SphereTable::augment_args(Command::new(TABLE)).about(about);
        Spheres::augment_args(command)
            .args_conflicts_with_subcommands(true)
            .subcommand_negates_reqs(true)
            .subcommand(table)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl SpheresCommand {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        match self {
            Self::Fit(fit) => fit.run(talk),
            Self::Table(table) => table.run(),
        }
    }
}

#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Args)]
#[command(mut_arg("count", |count| count.short('n').required_unless_present("job")))]
pub(crate) struct Spheres {
    #[command(flatten)]
    asked: AskedJob<SphereJob>,
    /// Print {"spheres": [{"center", "radius"}], "outside_volume", "union_volume", "solid_volume", "history",
    /// "certainty"} on stdout. The first volume sums what each sphere has outside of the solid; of the union, overlaps
    /// count once
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
pub(crate) struct SphereTable {
    /// The table, a .safetensors file
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Number of bands, 1 to 8
    #[arg(long, value_name = "N", default_value = "4", value_parser = order)]
    order: usize,
    /// The width of a window on the visibility, in bands [default: none]
    #[arg(long, value_name = "H", value_parser = values::positive)]
    window: Option<f64>,
    /// The least eigenvalue of a logarithm, as a part of the largest, above 0 and up to 1 [default: 0.02]
    #[arg(long, value_name = "X", value_parser = values::clamp)]
    clamp: Option<f64>,
    /// The most that a logarithm between two rows may be off, as a norm, above 0; 0.01 is 0.3 % of visibility in the root mean square
    /// [default: 0.01]
    #[arg(long, value_name = "X", value_parser = values::positive)]
    tolerance: Option<f64>,
}

fn order(text: &str) -> Result<usize, String> {
    values::whole(text, 1, 8, "an order (number of bands)")
}

impl Spheres {
    fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let Some(job) = self.asked.job()? else { return Ok(()) };
        let Some(files) = job.files() else { bail!("-o: expected the name of a file") };
        let is_kept = job.method == SphereFitMethod::Variational;
        let kept = if is_kept { Kept::In(files.checkpoint()) } else { Kept::Nowhere };
        let (_, found) = watched_job(talk, kept, |work| job.run(work))?;
        tell_if_too_late(files.output(), talk);
        if self.json {
            return output::print_json(&found);
        }
        output::print(&format!(
            "spheres         {}\nsolid volume    {:.6}\nunion volume    {:.6}\noutside volume  {:.6}, {:.2} % of that of \
             the solid, summed over spheres\nrounds          {}\ncertain         {:.1} % of the box\n",
            found.spheres.len(),
            found.solid_volume,
            found.union_volume,
            found.outside_volume,
            100.0 * found.outside_volume / found.solid_volume,
            found.history.len().saturating_sub(1),
            100.0 * found.certainty,
        ))
    }
}

impl SphereTable {
    fn run(&self) -> anyhow::Result<()> {
        output::check_safetensors(&self.output)?;
        output::prepare_file(&self.output, output::NO_INPUTS)?;
        let defaults = LogTableOptions::default();
        let mut options = defaults
            .order(self.order)
            .clamp(self.clamp.unwrap_or(defaults.clamp))
            .tolerance(self.tolerance.unwrap_or(defaults.tolerance));
        options.window = self.window;
        let table = LogTable::new(&options)?;
        write_log_table(&self.output, &table)?;
        output::print(&format!("order           {}\nrows            {}\n", table.order(), table.row_count()))
    }
}
