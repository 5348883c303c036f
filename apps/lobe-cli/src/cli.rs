//! The command line as a whole: all sub-commands, and the options that apply to every one.

use std::ffi::OsString;
use std::fs;

use anyhow::Context as _;
use clap::{ArgMatches, Args, CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use lobe::io::parallel;
use lobe::sh::simd::Machine;

use crate::args::output::stdout_error;
use crate::args::values;
use crate::bake::{bake, compress, fit_lobes};
use crate::render::methods::RenderCommand;
use crate::run::batch::{One, lines, with_several};
use crate::run::failure::Failure;
use crate::run::system::check_stdout;
use crate::run::talk::Talk;
use crate::shadow::{field, lamp, spheres};
use crate::{compare, demo, env, export, import, light, manual, project, sh};

const EXAMPLES: &str = "\
Examples:
  lobe demo                                          all that follows in pictures, in the folder demo/
  lobe project sky.exr -o sky.sh.json --order 6      a photograph of a sky as 36 colors
  lobe sh convolve sky.sh.json --kernel cosine -o - | lobe sh eval - --dir 0,0,1
                                                     the irradiance of the ground under that sky
  lobe env reconstruct sky.sh.json -o sky.png        what 36 colors keep of it
  lobe bake room.glb -o baked.glb                    the same room, its vertices knowing shadows and reflections

bundled:sunset and bundled:studio name the two environment maps that come with the program.
Directions are right-handed with +z up; \"order n\" means n bands, n² coefficients.
Exit code: 0 done, 1 compared and different or looked for a sun and found none, 2 error, or stopped in order by
Ctrl-C, SIGTERM or SIGHUP; a command without an order to keep ends by the signal (130).";

/// Light from everywhere in a few numbers: spherical-harmonic expansions of environment maps.
#[derive(Parser)]
#[command(name = "lobe", version, after_help = EXAMPLES, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    everywhere: Everywhere,
}

/// Options of every sub-command.
#[derive(Args)]
#[command(next_help_heading = "Options of every command")]
struct Everywhere {
    /// Number of threads to compute with; the results are the same for any [default: all processors]
    #[arg(long, global = true, value_name = "N", value_parser = threads)]
    threads: Option<usize>,
    /// Print no notes and no progress on stderr, only errors
    #[arg(long, short, global = true)]
    quiet: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Write a folder with a page that shows everything on built-in data
    Demo(demo::Demo),
    /// Project an environment map onto spherical harmonics
    Project(project::Project),
    /// Write a light with a name as an expansion: sun, lamp, window, sky
    Light(light::LightCommand),
    /// Bake what a scene does to light, for any light to come
    Bake(bake::Bake),
    /// Render a scene under any light: by transfer at once, or path traced for reference
    #[command(subcommand)]
    Render(RenderCommand),
    /// Compare two pictures: RMSE, relative MSE, PSNR, FLIP; test whether chance explains the difference
    Compare(compare::Compare),
    /// Write transfer in fewer bytes, by clustered principal components
    Compress(compress::Compress),
    /// Write transfer as lobes that turn with a surface that bends
    FitLobes(fit_lobes::FitLobes),
    /// Bake how much of the sky an object hides from points around it, so that its shadow can follow it
    Field(field::Field),
    /// Write the light that a lamp sends to every point around it
    Lamp(lamp::LampCommand),
    /// Fit few spheres to an object, so that its shadow can follow it; table: what spheres need
    Spheres(spheres::SpheresCommand),
    /// Work on expansions in .sh.json files
    #[command(subcommand)]
    Sh(ShCommand),
    /// Work on environment maps, pictures of everything around a point
    #[command(subcommand)]
    Env(EnvCommand),
    /// Write the light of an environment map as the files that an engine reads; shader: functions for shaders
    Export(export::export::Export),
    /// Read the spherical harmonics of an engine as an expansion
    Import(import::Import),
    /// Write the manual, a page for every command
    Man(manual::ManPages),
    /// Print the script with which a shell completes commands and options
    Completions(manual::Completions),
}

#[derive(Subcommand)]
enum ShCommand {
    /// Print the order, the range of values and the energy of each band of an expansion
    Info(sh::info::ShInfo),
    /// Print the values of an expansion towards directions
    Eval(sh::eval::ShEval),
    /// Turn an expansion
    Rotate(sh::rotate::ShRotate),
    /// Add expansions
    Add(sh::add::ShAdd),
    /// Multiply an expansion by a number or a color
    Scale(sh::scale::ShScale),
    /// Mirror an expansion along an axis
    Mirror(sh::mirror::ShMirror),
    /// Multiply two functions given as expansions
    Product(sh::product::ShProduct),
    /// Take the logarithm of a visibility, so that shadows add up
    Log(sh::log::ShLog),
    /// Raise e to a log-visibility: what several occluders leave visible
    Exp(sh::exp::ShExp),
    /// Write the light that arrives at a point of a grid of transfer, from lobe bake --grid
    Incident(sh::incident::ShIncident),
    /// Convolve an expansion with a kernel that is symmetric about its axis
    Convolve(sh::convolve::ShConvolve),
    /// Scale the bands of an expansion, so that it rings less
    Window(sh::window::ShWindow),
    /// Make an expansion non-negative, with as little change as that takes
    Dering(sh::dering::ShDering),
    /// Find the least value of an expansion, with proof
    Min(sh::min::ShMin),
    /// Find all local maxima of an expansion
    Peaks(sh::peaks::ShPeaks),
    /// Find directional lights and ambient light in an expansion
    Lights(sh::lights::ShLights),
    /// Draw an expansion: as a balloon, on the unfolded cube, or in a cross-section
    Plot(sh::plot::ShPlot),
    /// Write coefficients as pyshtools, healpy, e3nn, Ambisonics and others keep them, or read theirs
    Convert(sh::convert::ShConvert),
    /// Print irradiance in a small encoding, or as the constants of a shader
    Encode(sh::encode::ShEncode),
    /// Compare small encodings of the irradiance of an environment map with the truth
    Encodings(sh::encodings::ShEncodings),
}

#[derive(Subcommand)]
enum EnvCommand {
    /// Print the size and the range of values of an environment map
    Info(env::info::EnvInfo),
    /// Write a map in another mapping, size or kind of file
    Convert(env::convert::EnvConvert),
    /// Turn a map
    Rotate(env::rotate::EnvRotate),
    /// Make a map brighter or darker, or clamp it
    Adjust(env::adjust::EnvAdjust),
    /// Take the sun out of a map: print it as a directional light, write the sky without it
    Sun(env::sun::EnvSun),
    /// Filter a map for glossy reflection
    Prefilter(env::prefilter::EnvPrefilter),
    /// Draw a ball and a torus under a map by every technique of environment mapping
    Show(env::show::EnvShow),
    /// Write the irradiance for every direction that a surface may face
    Irradiance(env::irradiance::EnvIrradiance),
    /// Write an expansion as a picture
    Reconstruct(env::reconstruct::EnvReconstruct),
    /// Write a sky from a formula, as a picture or as an expansion
    Sky(env::sky::EnvSky),
    /// Print the net flow of light at the place of a picture, and through surfaces
    VectorIrradiance(env::vector_irradiance::EnvVectorIrradiance),
    /// Print the light of a sphere, a disc or a polygon at a place: exact, as a point, as a parallel beam
    AreaLight(env::area_light::EnvAreaLight),
    /// Print what a surface reflects of light that comes evenly from everywhere
    Ambient(env::ambient::EnvAmbient),
    /// Write the table of reflectance that goes with prefiltered maps
    Dfg(env::dfg::EnvDfg),
}

fn threads(text: &str) -> Result<usize, String> {
    values::whole(text, 1, parallel::MAX_THREADS, "a number of threads")
}

/// What the command line asks for.
pub(crate) enum Asked {
    /// One command.
    Command(Box<Cli>),
    /// A command for each of several files.
    Batch(Vec<One>),
}

/// Reads the command line.
pub(crate) fn parse() -> Result<Asked, Failure> {
    let several = with_several(with_negative_numbers(Cli::command()));
    let args = with_method(&several, std::env::args_os().collect());
    let usage = |error| Failure::Usage { error: Box::new(error), command: command_meant(args.iter().cloned()) };
    let matches = several.clone().try_get_matches_from(&args).map_err(usage)?;
    let lines = lines(&several, &matches, &args)?;
    if lines.is_empty() { parse_one(&args).map(|cli| Asked::Command(Box::new(cli))) } else { Ok(Asked::Batch(lines)) }
}

/// Reads a line with one file.
fn parse_one(args: &[OsString]) -> Result<Cli, Failure> {
    let usage = |error| Failure::Usage { error: Box::new(error), command: command_meant(args.iter().cloned()) };
    let matches = with_negative_numbers(Cli::command()).try_get_matches_from(args).map_err(usage)?;
    let cli = Cli::from_arg_matches(&matches).map_err(usage)?;
    if prints(&matches, "lobe") {
        check_stdout().map_err(stdout_error)?;
    }
    Ok(cli)
}

/// `lobe render SCENE`, which names no sub-command, means `lobe render baked SCENE`.
fn with_method(command: &clap::Command, mut args: Vec<OsString>) -> Vec<OsString> {
    // Options that stand before a command are those of the program: a flag, or one with a number.
    let is_option = |word: &OsString| {
        let word = word.to_string_lossy();
        word.starts_with('-') || word.parse::<usize>().is_ok()
    };
    let render = args.iter().position(|word| word == "render").filter(|&at| args[1..at].iter().all(is_option));
    let (Some(at), Some(methods)) = (render, command.find_subcommand("render")) else { return args };
    let Some(first) = args[at + 1..].iter().position(|word| !is_option(word)) else { return args };
    let word = &args[at + 1 + first];
    // A word that cannot be a scene is a sub-command, or was meant to be one.
    let is_bare = first == 0 && !word.to_string_lossy().contains(['.', ':', '/', '\\']);
    if !is_bare && methods.find_subcommand(word).is_none() {
        args.insert(at + 1, "baked".into());
    }
    args
}

/// Commands that print a text without having --json.
const PRINT_TEXT: [&str; 2] = ["demo", "table"];

/// Commands that print only with --json: without it their report is a note.
const PRINT_JSON_ALONE: [&str; 3] = ["bake", "dering", "exp"];

/// Whether the command of this name prints a result on stdout when the work is done.
fn prints(matches: &ArgMatches, name: &str) -> bool {
    if let Some((name, matches)) = matches.subcommand() {
        return prints(matches, name);
    }
    let has = |option| matches.try_contains_id(option).unwrap_or_default();
    // The report of a shard is a note, and a picture of irradiance has none.
    let is_silent = has("shard") || name == "irradiance" && !has("dirs") || PRINT_JSON_ALONE.contains(&name);
    match matches.try_get_one::<bool>("json").ok().flatten() {
        Some(as_json) => *as_json || !is_silent,
        None => PRINT_TEXT.contains(&name),
    }
}

/// Lets every option take a number below zero, which it may refuse in its own words.
fn with_negative_numbers(command: clap::Command) -> clap::Command {
    let names: Vec<String> = command.get_subcommands().map(|sub| sub.get_name().to_owned()).collect();
    let command = command.mut_args(|arg| {
        let takes_number = arg.get_action().takes_values() && !arg.is_positional();
        if takes_number && !arg.is_allow_hyphen_values_set() { arg.allow_negative_numbers(true) } else { arg }
    });
    names.into_iter().fold(command, |command, name| command.mut_subcommand(name, with_negative_numbers))
}

/// The command that a command line names, whatever is wrong with the rest of it: `lobe`, `lobe sh eval`.
fn command_meant(args: impl Iterator<Item = OsString>) -> String {
    let mut command = Cli::command();
    let mut name = command.get_name().to_owned();
    for word in args.skip(1) {
        if let Some(sub) = command.find_subcommand(&word).cloned() {
            name = format!("{name} {}", sub.get_name());
            command = sub;
        }
    }
    name
}

/// Does what the command line asks for.
pub(crate) fn run(asked: Asked) -> Result<(), Failure> {
    match asked {
        Asked::Command(cli) => {
            prepare(&cli.everywhere)?;
            cli.command.run(Talk { quiet: cli.everywhere.quiet })
        }
        Asked::Batch(lines) => run_all(&lines),
    }
}

/// Runs the command of each file. One that fails is told, and the others are done all the same.
fn run_all(lines: &[One]) -> Result<(), Failure> {
    let mut failed = 0;
    for (done, one) in lines.iter().enumerate() {
        let cli = parse_one(&one.words)?;
        if done == 0 {
            prepare(&cli.everywhere)?;
        }
        let talk = Talk { quiet: cli.everywhere.quiet };
        if lines.len() > 1 {
            talk.note(&one.file.display().to_string(), &format!("file {} of {}", done + 1, lines.len()));
        }
        let folder = one.result.parent().unwrap_or(&one.result);
        if let Err(error) = fs::create_dir_all(folder) {
            return Err(anyhow::anyhow!("{}: the folder cannot be made: {error}", folder.display()).into());
        }
        if let Err(failure) = cli.command.run(talk) {
            failure.report();
            failed += 1;
        }
    }
    match failed {
        0 => Ok(()),
        // Its line says all.
        1 if lines.len() == 1 => Err(Failure::Told),
        _ => Err(anyhow::anyhow!("{failed} of {} files failed; their lines are above", lines.len()).into()),
    }
}

/// Sees to the machine, before anything is computed.
fn prepare(everywhere: &Everywhere) -> Result<(), Failure> {
    Machine::check_limit().map_err(anyhow::Error::from)?;
    lobe::io::choose_huge_pages().map_err(anyhow::Error::from)?;
    if everywhere.threads.is_none() {
        parallel::check_environment().map_err(anyhow::Error::from)?;
    }
    if let Some(count) = everywhere.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count);
        pool.build_global()
            .with_context(|| format!("--threads {count}: the system does not give that many threads"))?;
    }
    Ok(())
}

impl Command {
    fn run(self, talk: Talk) -> Result<(), Failure> {
        match self {
            Self::Demo(args) => args.run(talk)?,
            Self::Project(args) => args.run(talk)?,
            Self::Light(args) => args.run()?,
            Self::Bake(args) => args.run(talk)?,
            Self::Render(args) => args.run(talk)?,
            Self::Compare(args) => {
                if !args.run(talk)? {
                    return Err(Failure::Different);
                }
            }
            Self::Compress(args) => args.run(talk)?,
            Self::FitLobes(args) => args.run(talk)?,
            Self::Field(args) => args.run(talk)?,
            Self::Lamp(args) => args.run(talk)?,
            Self::Spheres(args) => args.run(talk)?,
            Self::Sh(ShCommand::Info(args)) => args.run()?,
            Self::Sh(ShCommand::Eval(args)) => args.run()?,
            Self::Sh(ShCommand::Rotate(args)) => args.run()?,
            Self::Sh(ShCommand::Add(args)) => args.run()?,
            Self::Sh(ShCommand::Scale(args)) => args.run()?,
            Self::Sh(ShCommand::Mirror(args)) => args.run()?,
            Self::Sh(ShCommand::Product(args)) => args.run()?,
            Self::Sh(ShCommand::Log(args)) => args.run()?,
            Self::Sh(ShCommand::Exp(args)) => args.run(talk)?,
            Self::Sh(ShCommand::Incident(args)) => args.run(talk)?,
            Self::Sh(ShCommand::Convolve(args)) => args.run(talk)?,
            Self::Sh(ShCommand::Window(args)) => args.run(talk)?,
            Self::Sh(ShCommand::Dering(args)) => args.run(talk)?,
            Self::Sh(ShCommand::Min(args)) => args.run(talk)?,
            Self::Sh(ShCommand::Peaks(args)) => args.run(talk)?,
            Self::Sh(ShCommand::Lights(args)) => args.run(talk)?,
            Self::Sh(ShCommand::Plot(args)) => args.run()?,
            Self::Sh(ShCommand::Convert(args)) => args.run()?,
            Self::Sh(ShCommand::Encode(args)) => args.run(talk)?,
            Self::Sh(ShCommand::Encodings(args)) => args.run(talk)?,
            Self::Env(EnvCommand::Info(args)) => args.run(talk)?,
            Self::Env(EnvCommand::Convert(args)) => args.run(talk)?,
            Self::Env(EnvCommand::Rotate(args)) => args.run(talk)?,
            Self::Env(EnvCommand::Adjust(args)) => args.run(talk)?,
            Self::Env(EnvCommand::Sun(args)) => args.run(talk)?,
            Self::Env(EnvCommand::Prefilter(args)) => args.run(talk)?,
            Self::Env(EnvCommand::Show(args)) => args.run(talk)?,
            Self::Env(EnvCommand::Irradiance(args)) => args.run(talk)?,
            Self::Env(EnvCommand::Reconstruct(args)) => args.run(talk)?,
            Self::Env(EnvCommand::Sky(args)) => args.run(talk)?,
            Self::Env(EnvCommand::VectorIrradiance(args)) => args.run(talk)?,
            Self::Env(EnvCommand::AreaLight(args)) => args.run()?,
            Self::Env(EnvCommand::Ambient(args)) => args.run()?,
            Self::Env(EnvCommand::Dfg(args)) => args.run(talk)?,
            Self::Export(args) => args.run(talk)?,
            Self::Import(args) => args.run()?,
            Self::Man(args) => args.run(with_several(Cli::command()))?,
            Self::Completions(args) => args.run(with_several(Cli::command()))?,
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn the_command_meant_is_found_behind_options() {
        for (line, name) in [
            ("lobe --threads 2 sh --quiet eval p.sh.json --dir x", "lobe sh eval"),
            ("lobe bakery x", "lobe"),
            ("lobe project sh.exr", "lobe project"),
            ("lobe", "lobe"),
        ] {
            assert_eq!(command_meant(line.split(' ').map(OsString::from)), name, "{line}");
        }
    }

    #[test]
    fn every_option_of_every_command_is_explained() {
        fn check(command: &clap::Command, path: &str) {
            assert!(command.get_about().is_some(), "{path} is not explained");
            for arg in command.get_arguments() {
                assert!(arg.get_help().is_some(), "{path}: {} is not explained", arg.get_id());
            }
            for sub in command.get_subcommands() {
                check(sub, &format!("{path} {}", sub.get_name()));
            }
        }
        let mut command = Cli::command();
        command.build();
        check(&command, "lobe");
    }
}
