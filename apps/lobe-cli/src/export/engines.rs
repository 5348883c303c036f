//! `lobe export MAP`: the light of a map as the files that engines read.

use std::collections::BTreeSet;
use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use lobe::env::{Engine, ExportOptions, export_light};

use crate::args::map_input::{MapInput, OF_LARGER};
use crate::args::output;
use crate::args::picture::note_moved;
use crate::args::values;
use crate::env::prefilter::OF_SOURCE;
use crate::render::light::{SunInput, note_apart};
use crate::run::talk::Talk;

/// The name that stands for all engines.
const ALL: &str = "all";

/// Bytes for each texel of the faces: the source, twice as fine, a cube of the whole sky, a chain for each of up to
/// four spacings of levels, and what one of them is encoded in; all files together, at most as many bytes.
const OF_CHAINS: u64 = 256;

#[derive(Args)]
pub(crate) struct ExportLight {
    #[command(flatten)]
    input: MapInput,
    /// The engines, with commas between them. Each gets its own frame and faces, roughness of levels, turn of the
    /// panorama and form of coefficients
    #[arg(long, value_name = "NAME[,NAME..]", required = true, value_delimiter = ',', value_parser = engine())]
    engine: Vec<Engines>,
    /// The folder in which each engine gets a folder of its own: DIR/three, DIR/babylon. A README.md in it says what
    /// the files are; a program in it loads them
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// The size of the faces of cubes, a power of two from 16 to 8192
    #[arg(long, value_name = "N", default_value_t = ExportOptions::default().size, value_parser = values::rows)]
    size: usize,
    #[command(flatten)]
    suns: SunInput,
}

/// An engine, or all.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Engines {
    One(Engine),
    All,
}

/// Reads an engine by its name; help pages list all of them.
fn engine() -> impl TypedValueParser<Value = Engines> {
    let known = Engine::ALL
        .map(|engine| PossibleValue::new(engine.name()).help(format!("{}; {}", engine.facts().title, engine.tried())));
    let all = PossibleValue::new(ALL).help("All of them");
    PossibleValuesParser::new(known.into_iter().chain([all]))
        .try_map(|name| if name == ALL { Ok(Engines::All) } else { name.parse().map(Engines::One) })
}

impl ExportLight {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let engines = self.engines();
        // A file of suns that cannot be read is refused before anything takes time.
        self.suns.given()?;
        if let Err(error) = self.options().check() {
            bail!("--size: {error}");
        }
        if self.output.is_file() {
            bail!("-o: {} is a file; name a folder", self.output.display());
        }
        let inputs = self.input.files()?;
        for engine in &engines {
            let folder = self.output.join(engine.name());
            if folder.is_file() {
                bail!("-o: {} is a file where the folder of {engine} goes; move it away", folder.display());
            }
            output::prepare_files(&folder, engine.files(), &inputs)?;
        }
        let map = self.input.read(talk)?;
        let faces = 6 * (self.size as u64).pow(2);
        let texels = map.width() as u64 * map.height() as u64;
        let bytes = (OF_SOURCE + OF_LARGER).saturating_mul(texels).saturating_add(OF_CHAINS * faces);
        let what = format!("faces of {0} x {0} texels from a map of {1} x {2}", self.size, map.width(), map.height());
        self.input.memory().check(&what, bytes, "a smaller --size, or a smaller map")?;
        let name = self.input.name();
        let report =
            talk.watch("export", |job| export_light(&self.output, &map, &engines, &name, &self.options(), job))?;
        for (path, clamped) in &report.files {
            note_moved(&path.display().to_string(), *clamped, "", talk);
        }
        let takes_suns =
            engines.iter().any(|engine| !engine.facts().traces_paths && engine.facts().most_suns != Some(0));
        if takes_suns && !report.suns.is_empty() && self.suns.choice().looks() {
            note_apart(&report.suns, map.mean().luminance(), &name, talk);
            let paths = engines.iter().filter(|engine| engine.facts().traces_paths).map(|engine| engine.name());
            let paths: Vec<&str> = paths.collect();
            if !paths.is_empty() {
                talk.note(
                    &name,
                    &format!("{} trace paths, and keep suns of the map in their picture", paths.join(", ")),
                );
            }
        }
        Ok(())
    }

    /// The engines, each once, in the order of the command line.
    fn engines(&self) -> Vec<Engine> {
        let mut seen = BTreeSet::new();
        let all = self.engine.iter().flat_map(|engine| match engine {
            Engines::One(engine) => vec![*engine],
            Engines::All => Engine::ALL.to_vec(),
        });
        all.filter(|engine| seen.insert(engine.name())).collect()
    }

    fn options(&self) -> ExportOptions {
        ExportOptions::default().size(self.size).suns(self.suns.choice().clone())
    }
}
