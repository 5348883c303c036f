//! Memory limit: work that would take more is refused before it begins.

use std::path::Path;

use clap::{ArgMatches, Args, Command, FromArgMatches};
use lobe::io::{WorkOptions, option};
use lobe::prt::check_file_of_numbers;
use serde_json::Value;

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
        Ok(check_file_of_numbers(self.limit(), path, instead)?)
    }

    /// Refuses the work `what`, which takes at most `bytes`, if that is above the limit or the system does not give it;
    /// `instead` is what a user can ask for then.
    pub(crate) fn check(&self, what: &str, bytes: u64, instead: &str) -> anyhow::Result<()> {
        Ok(lobe::io::MemoryLimit::of(self.max_memory).check(what, bytes, instead)?)
    }
}
