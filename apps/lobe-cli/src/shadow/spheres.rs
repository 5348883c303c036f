//! `lobe spheres`: few spheres that stand for a mesh; and `lobe spheres table`: the logarithms that their shadows look up.

use std::path::PathBuf;

use anyhow::bail;
use clap::{ArgMatches, Args, Command, FromArgMatches};
use lobe::io::Job;
use lobe::shadow::{
    LogTable, LogTableOptions, ShadowError, SphereFitMethod, SphereFitOptions, SphereSetJson, fit_spheres,
    write_log_table, write_spheres,
};

use crate::args::exponential::clamp;
use crate::args::memory::MemoryLimit;
use crate::args::names::names;
use crate::args::open_scene::OpenScene;
use crate::args::output;
use crate::args::scene_input::SceneInput;
use crate::args::values;
use crate::run::bake_watch::{Checkpoint, tell_if_too_late, watched};
use crate::run::talk::Talk;

/// Limits of the options. Larger numbers are taken for typing errors.
const MAX_SPHERES: usize = 4096;
const MAX_POINTS: usize = 1 << 22;
const MAX_ROUNDS: usize = 10_000;

/// A fit that holds less than this part of the space for certain is noted.
const CERTAIN: f64 = 0.9;

/// Bytes that a point takes while the fit runs.
const POINT: u64 = 100;

/// What is said of a scene that is posed.
const IF_POSED: &str = "these spheres do not follow; --entity NAME fits some that do";

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
pub(crate) struct Spheres {
    #[command(flatten)]
    input: SceneInput,
    /// The spheres, a .safetensors file
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Only this entity of a scene: a mesh, or a node of a glTF file, by name or number; in the shape that its skin was bound to.
    /// The file then has the joints of each sphere, which follow them where an animation moves the entity
    #[arg(long, value_name = "NAME")]
    entity: Option<String>,
    /// Number of spheres, 1 to 4096
    #[arg(short = 'n', long, value_name = "K", value_parser = count)]
    count: usize,
    /// How they are found
    #[arg(long, value_enum, default_value = "variational")]
    method: Method,
    /// About how many points of the solid the spheres must cover [default: 12288]
    #[arg(long, value_name = "N", value_parser = points)]
    points: Option<usize>,
    /// medial-axis: balls keep the size that they were selected with, as published; without this each shrinks at last to the points that
    /// are its own
    #[arg(long)]
    no_shrink: bool,
    /// variational: rounds at most [default: 100]
    #[arg(long, value_name = "N", value_parser = rounds)]
    rounds: Option<usize>,
    /// Another seed gives other points
    #[arg(long, value_name = "S", default_value = "0")]
    seed: u64,
    #[command(flatten)]
    memory: MemoryLimit,
    /// Start anew, even if there is a checkpoint of a fit that was stopped
    #[arg(long)]
    fresh: bool,
    /// Print {"spheres": [{"center", "radius"}], "outside_volume", "union_volume", "solid_volume", "history", "certainty"} on
    /// stdout. The first volume sums what each sphere has outside of the solid; of the union, overlaps count once
    #[arg(long)]
    json: bool,
}

names! {
    enum Method for SphereFitMethod {
        /// Least volume outside the solid, by Lloyd's algorithm with teleportation
        Variational,
        /// Balls of the medial axis, selected greedily: faster, and worse
        MedialAxis,
    }
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
    #[arg(long, value_name = "X", value_parser = clamp)]
    clamp: Option<f64>,
    /// The most that a logarithm between two rows may be off, as a norm, above 0; 0.01 is 0.3 % of visibility in the root mean square
    /// [default: 0.01]
    #[arg(long, value_name = "X", value_parser = values::positive)]
    tolerance: Option<f64>,
}

fn order(text: &str) -> Result<usize, String> {
    values::whole(text, 1, 8, "an order (number of bands)")
}

fn count(text: &str) -> Result<usize, String> {
    values::whole(text, 1, MAX_SPHERES, "a number of spheres")
}

fn points(text: &str) -> Result<usize, String> {
    values::whole(text, 1, MAX_POINTS, "a number of points")
}

fn rounds(text: &str) -> Result<usize, String> {
    values::whole(text, 0, MAX_ROUNDS, "a number of rounds")
}

impl Spheres {
    fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let is_variational = self.method == Method::Variational;
        if self.rounds.is_some() && !is_variational {
            bail!("--rounds: only of --method variational; leave the option out");
        }
        if self.no_shrink && is_variational {
            bail!("--no-shrink: only of --method medial-axis; leave the option out");
        }
        output::check_safetensors(&self.output)?;
        output::prepare_file(&self.output, &[self.input.path()])?;
        let opened = OpenScene::of_shapes(&self.input, &self.memory, talk)?;
        let (whole, entity) = opened.whole_or_entity(self.entity.as_deref(), IF_POSED)?;
        // Spheres shrink with what morph targets stretch.
        let scene = match &entity {
            Some((animated, entity)) => animated.morphed_scene(entity, &animated.widest_weights(entity)?)?,
            None => whole,
        };
        let options = self.options();
        let what = format!("a fit to {} points", options.samples);
        self.memory.check(&what, POINT * options.samples as u64, "fewer --points")?;
        let checkpoint = Checkpoint::beside(&self.output);
        if self.fresh {
            checkpoint.discard()?;
        }
        // What cannot be fitted is the mesh.
        let named = |error: ShadowError| match error {
            ShadowError::Options(message) => ShadowError::Invalid { place: self.input.name(), message },
            other => other,
        };
        let fit = |mut job: Job<'_>| {
            let (spheres, report) = fit_spheres(&scene, &options, job.reborrow()).map_err(named)?;
            let bound = match &entity {
                Some((animated, entity)) => spheres.bind_to(animated, entity, &mut job)?,
                None => spheres,
            };
            Ok::<_, ShadowError>((bound, report))
        };
        let (spheres, report) = if is_variational {
            checkpoint.watched_fit(talk, fit)?
        } else {
            let fitted = watched(talk, "fit", fit)?;
            fitted.or_else(|_| bail!("stopped; nothing is written, and the same command starts anew"))?
        };
        if report.certainty < CERTAIN {
            let certain = 100.0 * report.certainty;
            let text = format!(
                "is not closed: of {certain:.0} % of its box it is certain whether it is solid; spheres cover what is more \
                 likely so than not"
            );
            talk.note(&self.input.name(), &text);
        }
        write_spheres(&self.output, &spheres)?;
        checkpoint.finish();
        tell_if_too_late(&self.output, talk);
        let json = SphereSetJson::new(&spheres, &report);
        if self.json {
            return output::print_json(&json);
        }
        output::print(&format!(
            "spheres         {}\nsolid volume    {:.6}\nunion volume    {:.6}\noutside volume  {:.6}, {:.2} % of that of the solid, summed over spheres\n\
             rounds          {}\ncertain         {:.1} % of the box\n",
            json.spheres.len(),
            json.solid_volume,
            json.union_volume,
            json.outside_volume,
            100.0 * json.outside_volume / json.solid_volume,
            json.history.len().saturating_sub(1),
            100.0 * report.certainty,
        ))
    }

    fn options(&self) -> SphereFitOptions {
        let defaults = SphereFitOptions::default();
        defaults
            .clone()
            .count(self.count)
            .method(self.method.into())
            .samples(self.points.unwrap_or(defaults.samples))
            .shrink(!self.no_shrink)
            .rounds(self.rounds.unwrap_or(defaults.rounds))
            .seed(self.seed)
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
