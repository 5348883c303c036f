//! Sharing long work among machines: shards of it, and the command that puts them together.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use lobe::io::{IoError, Shard, merge_shards};
use serde::Serialize;

use crate::args::output;
use crate::run::bake_watch::{Checkpoint, watched};
use crate::run::talk::Talk;

#[derive(Args, Default)]
#[command(next_help_heading = "Sharing among machines")]
pub(crate) struct Sharing {
    /// Do part I of N of the work, and write it as a shard, a .safetensors file. Ctrl-C leaves what is done, and the same command
    /// goes on from there
    #[arg(long, value_name = "I/N", value_parser = str::parse::<Shard>, conflicts_with = "merge", hide_short_help = true)]
    pub(crate) shard: Option<Shard>,
    /// Take the work from these files, which are all shards of the same command on any machines: the output has the bytes that one
    /// machine alone gives it
    #[arg(long, value_name = "PART", num_args = 1.., hide_short_help = true)]
    pub(crate) merge: Vec<PathBuf>,
}

/// The JSON of a shard.
#[derive(Serialize)]
pub(crate) struct Done {
    pub(crate) shard: String,
    /// Receivers, sample points or pixels.
    pub(crate) points: usize,
    pub(crate) points_in_all: usize,
    pub(crate) seconds: f64,
}

impl Sharing {
    /// Refuses another kind of file than that of a shard.
    pub(crate) fn check(&self, output: &Path) -> anyhow::Result<()> {
        if self.shard.is_some() { output::check_safetensors(output) } else { Ok(()) }
    }

    /// The file that results are kept in: a shard is what it leaves, and shards come together beside what a bake that was stopped may have kept.
    pub(crate) fn checkpoint(&self, output: &Path) -> Checkpoint {
        if self.shard.is_some() {
            Checkpoint::at(output.to_path_buf())
        } else if self.merge.is_empty() {
            Checkpoint::beside(output)
        } else {
            let mut merged = output.as_os_str().to_owned();
            merged.push(".merged");
            Checkpoint::beside(Path::new(&merged)).untold()
        }
    }

    /// The files that are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.merge.iter().map(PathBuf::as_path)
    }

    /// Puts the shards together as a checkpoint, if there are some.
    pub(crate) fn merge(&self, checkpoint: &Checkpoint, talk: Talk) -> anyhow::Result<()> {
        if self.merge.is_empty() {
            return Ok(());
        }
        let place_of_all = checkpoint.path().display().to_string();
        let merged = watched(talk, "merge", |job| {
            merge_shards(&self.merge, checkpoint.path(), job).map_err(|error| match error {
                IoError::Invalid { place, message } if place == place_of_all => {
                    IoError::Invalid { place: "--merge".to_owned(), message }
                }
                error => error,
            })
        })?;
        merged.or_else(|at| bail!("stopped after {} of {} records, of which nothing is kept", at.done, at.total))
    }

    /// The outcome of work that took up shards. Where it failed, their checkpoint is of no use: it is made again in no time.
    pub(crate) fn merged<T>(&self, checkpoint: &Checkpoint, outcome: anyhow::Result<T>) -> anyhow::Result<T> {
        let Err(error) = outcome else { return outcome };
        if self.merge.is_empty() {
            return Err(error);
        }
        checkpoint.discard()?;
        if error.to_string().starts_with(&format!("{}: ", checkpoint.path().display())) {
            bail!(
                "{}: this shard and the others are not of this command: the scene, options that decide the numbers, the version of \
                 Lobe or the kind of machine (LOBE_SIMD) differ",
                self.merge[0].display()
            );
        }
        Err(error)
    }
}

impl Done {
    /// Says what a shard has, as JSON or in words.
    pub(crate) fn tell(&self, output: &Path, as_json: bool, talk: Talk) -> anyhow::Result<()> {
        if as_json {
            return output::print_json(self);
        }
        let Self { shard, points, points_in_all, seconds } = self;
        talk.note(
            &output.display().to_string(),
            &format!(
                "shard {shard}: {points} of {points_in_all} points in {seconds:.1} s; --merge puts all shards together"
            ),
        );
        Ok(())
    }
}
