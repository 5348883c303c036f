//! Memory limit: work that would take more is refused before it begins.

use std::fs::{self, File};
use std::io::Read as _;
use std::path::Path;

use clap::{ArgMatches, Args, Command, FromArgMatches};
use lobe::image::{ExrLayers, FileFormat};
use lobe::io::{WorkOptions, option};
use serde_json::Value;

/// Bytes in memory while a file is read for each of the file: it, its numbers, and what is made of them; of a scene its triangles.
/// Measured 2.0 of a table, 3.0 of a scene, which a bake made finer.
pub(crate) const COPIES: u64 = 3;

/// The limit without another choice, in GiB.
pub(crate) const DEFAULT_GIB: f64 = lobe::io::MemoryLimit::DEFAULT_GIB;

/// `--max-memory`, as of a bake. The scene is held against it when it is read, and the other work when that is known,
/// each alone.
pub(crate) struct MemoryLimit {
    max_memory: f64,
}

impl FromArgMatches for MemoryLimit {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = matches.get_one::<Value>("max_memory").and_then(Value::as_f64);
        Ok(Self::of(given.unwrap_or(DEFAULT_GIB)))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for MemoryLimit {
    fn augment_args(command: Command) -> Command {
        command.args(option::<WorkOptions>("max_memory").map(|arg| arg.hide_short_help(true)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl MemoryLimit {
    /// A limit in GiB.
    pub(crate) fn of(gib: f64) -> Self {
        Self { max_memory: gib }
    }

    /// The limit in GiB.
    pub(crate) fn gib(&self) -> f64 {
        self.max_memory
    }

    /// The limit as the library has it.
    pub(crate) fn limit(&self) -> lobe::io::MemoryLimit {
        lobe::io::MemoryLimit::of(self.max_memory)
    }

    /// The limit in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        lobe::io::MemoryLimit::of(self.max_memory).bytes()
    }

    /// Refuses a file of numbers that takes more than that while it is read, in any form: itself, its numbers, and what is made of
    /// them. One that cannot be read is left to its reader, which says so.
    pub(crate) fn check_file(&self, path: &Path, instead: &str) -> anyhow::Result<()> {
        let name = path.display().to_string();
        let check = |bytes: u64| self.check(&name, COPIES.saturating_mul(bytes), instead);
        check(fs::metadata(path).map_or(0, |file| file.len()))?;
        let mut begin = [0; 4];
        let is_exr = File::open(path).and_then(|mut file| file.read_exact(&mut begin)).is_ok()
            && matches!(FileFormat::of_bytes(&begin, &name), Ok(FileFormat::OpenExr));
        if is_exr && let Ok(bytes) = fs::read(path) {
            check(ExrLayers::bytes_in_memory(&bytes, &name)?)?;
        }
        Ok(())
    }

    /// Refuses the work `what`, which takes at most `bytes`, if that is above the limit or the system does not give it;
    /// `instead` is what a user can ask for then.
    pub(crate) fn check(&self, what: &str, bytes: u64, instead: &str) -> anyhow::Result<()> {
        Ok(lobe::io::MemoryLimit::of(self.max_memory).check(what, bytes, instead)?)
    }
}
