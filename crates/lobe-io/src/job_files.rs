//! The files of long work beside its output: what is kept until that is written.

use std::fmt::Display;
use std::fs;
use std::path::{Path, PathBuf};

use crate::error::IoError;
use crate::job::Job;
use crate::options::field::OptionError;
use crate::records::merge::merge_shards;
use crate::room::expect_room;
use crate::shard::Shard;
use crate::staged::{check_writable, remove_abandoned};

/// The output of long work, and the checkpoint beside it, in which results are kept while they are found.
///
/// [Rounds of splitting](JobFiles::round) have files of their own, whose names go on from that of the checkpoint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JobFiles {
    output: PathBuf,
    checkpoint: PathBuf,
}

impl JobFiles {
    /// The files of work with this output, of one shard of it, or of what is put together of shards.
    ///
    /// # Errors
    /// [`IoError::OfJob`] without an output.
    pub fn of(output: Option<&Path>, shard: Option<Shard>, merges: bool) -> Result<Self, IoError> {
        let Some(output) = output.map(Path::to_path_buf) else {
            return Err(OptionError::new("output", "expected the name of a file").into());
        };
        Ok(match (shard, merges) {
            // A shard is what it leaves.
            (Some(_), _) => Self::kept_in(output.clone(), output),
            (None, false) => Self::beside(output),
            // Beside what work that was stopped may have kept.
            (None, true) => Self::of_merge(output),
        })
    }

    /// An output with its checkpoint beside it.
    #[must_use]
    pub fn beside(output: PathBuf) -> Self {
        Self { checkpoint: appended(&output, ".checkpoint"), output }
    }

    /// An output that is made of shards.
    #[must_use]
    pub fn of_merge(output: PathBuf) -> Self {
        Self { checkpoint: appended(&output, ".merged.checkpoint"), output }
    }

    /// An output whose results are kept in `checkpoint`.
    #[must_use]
    pub fn kept_in(output: PathBuf, checkpoint: PathBuf) -> Self {
        Self { output, checkpoint }
    }

    /// The output.
    #[must_use]
    pub fn output(&self) -> &Path {
        &self.output
    }

    /// The file that results are kept in.
    #[must_use]
    pub fn checkpoint(&self) -> &Path {
        &self.checkpoint
    }

    /// The files of a further part of the work, whose checkpoint ends so.
    #[must_use]
    pub fn of_part(&self, ending: &str) -> Self {
        Self { output: self.output.clone(), checkpoint: appended(&self.checkpoint, ending) }
    }

    /// The file of a round of splitting, from 0, whose results are kept in `checkpoint` at last.
    #[must_use]
    pub fn round(checkpoint: &Path, round: usize) -> PathBuf {
        appended(checkpoint, &format!(".split-{round}"))
    }

    /// The files of all rounds of splitting that are there, in their order.
    #[must_use]
    pub fn rounds(&self) -> Vec<PathBuf> {
        (0..).map(|round| Self::round(&self.checkpoint, round)).take_while(|path| path.exists()).collect()
    }

    /// Refuses an output that could not be written, or that is one of the inputs, which would be lost. Clears away what
    /// killed programs have left beside it.
    ///
    /// # Errors
    /// [`IoError::OfJob`] for an input, [`IoError::Io`] if the system would refuse.
    pub fn expect_writable<'a>(&self, inputs: impl IntoIterator<Item = &'a Path>) -> Result<(), IoError> {
        let found = self.output.canonicalize();
        let is_same = |input: &Path| matches!((&found, input.canonicalize()), (Ok(out), Ok(input)) if *out == input);
        if inputs.into_iter().any(is_same) {
            let message = format!("{} is an input, which would be lost; give another name", self.output.display());
            return Err(OptionError::new("output", message).into());
        }
        check_writable(&self.output).map_err(|source| IoError::io(&self.output, source))?;
        remove_abandoned(&self.output);
        Ok(())
    }

    /// Refuses to begin work whose output of `bytes` does not fit on the disk, beside results of `checkpoint` bytes, of
    /// which some may be there already.
    ///
    /// # Errors
    /// [`IoError::Io`], with what is needed and what is there.
    pub fn expect_room(&self, bytes: u64, checkpoint: u64) -> Result<(), IoError> {
        let there = fs::metadata(&self.checkpoint).map_or(0, |found| found.len());
        expect_room(&self.output, bytes.saturating_add(checkpoint.saturating_sub(there)))
    }

    /// Forgets earlier work.
    ///
    /// # Errors
    /// [`IoError::Io`] for a file that cannot be removed.
    pub fn discard(&self) -> Result<(), IoError> {
        let rounds = self.rounds();
        for path in [&self.checkpoint].into_iter().chain(rounds.iter().rev()).filter(|path| path.exists()) {
            fs::remove_file(path).map_err(|source| IoError::io(path, source))?;
        }
        Ok(())
    }

    /// Removes the files that were kept, when the results are safe. The same work takes up a file that cannot be removed,
    /// and has nothing left to do.
    pub fn finish(&self) {
        let _ = fs::remove_file(&self.checkpoint);
        self.finish_rounds();
    }

    /// The same of rounds of splitting alone, when the results are safe in the checkpoint itself. The last goes first,
    /// so that what is left by a fault has no gaps.
    pub fn finish_rounds(&self) {
        for path in self.rounds().iter().rev() {
            let _ = fs::remove_file(path);
        }
    }

    /// Puts shards together as the checkpoint.
    ///
    /// # Errors
    /// Those of [`merge_shards`], for shards of other work, missing ones and those that are there twice.
    pub fn merge(&self, parts: &[PathBuf], job: Job<'_>) -> Result<(), IoError> {
        let place_of_all = self.checkpoint.display().to_string();
        merge_shards(parts, &self.checkpoint, job).map_err(|error| match error {
            IoError::Invalid { place, message } if place == place_of_all => OptionError::new("merge", message).into(),
            error => error,
        })
    }

    /// The outcome of work that took up shards. Where it failed, their checkpoint is of no use: it is made again in no
    /// time, and would be in the way of other work.
    ///
    /// # Errors
    /// Those of the outcome, of shards that are of other work in words that name the first of them.
    pub fn outcome_of_merge<T, E>(&self, parts: &[PathBuf], outcome: Result<T, E>) -> Result<T, E>
    where
        E: Display + From<IoError>,
    {
        let (Err(error), Some(first)) = (&outcome, parts.first()) else { return outcome };
        self.discard()?;
        if !error.to_string().starts_with(&format!("{}: ", self.checkpoint.display())) {
            return outcome;
        }
        let message = "this shard and the others are not of this work: the scene, options that decide the numbers, the \
                       version of Lobe or the kind of machine (LOBE_SIMD) differ";
        Err(IoError::invalid(first, message).into())
    }
}

/// A path with an ending more.
fn appended(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(ending);
    name.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_all_rounds_are_found_and_removed() {
        let folder = tempfile::tempdir().unwrap();
        let files = JobFiles::beside(folder.path().join("out.glb"));
        let make = |name: &str| fs::write(folder.path().join(name), "x").unwrap();
        for remove in [JobFiles::finish, |files: &JobFiles| files.discard().unwrap()] {
            let names = ["out.glb.checkpoint", "out.glb.checkpoint.split-0", "out.glb.checkpoint.split-1"];
            names.into_iter().for_each(make);
            assert_eq!(files.rounds(), names[1..].iter().map(|name| folder.path().join(name)).collect::<Vec<_>>());
            remove(&files);
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "files left");
        }
    }

    #[test]
    fn what_no_disk_has_room_for_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let files = JobFiles::beside(folder.path().join("out.glb"));
        let huge = 1 << 60;
        for (bytes, of_bake) in [(huge, 0), (0, huge), (u64::MAX, u64::MAX)] {
            let refusal = files.expect_room(bytes, of_bake).unwrap_err().to_string();
            assert!(refusal.contains("out.glb: expected ") && refusal.contains(" MiB of free space"), "{refusal}");
        }
        assert!(files.expect_room(1, 1).is_ok(), "two bytes");
    }
}
