//! The files of a bake beside its output: what is kept until that is written.

use std::fs;
use std::path::{Path, PathBuf};

use lobe_io::{IoError, Job, OptionError, check_writable, expect_room, merge_shards, remove_abandoned};

use crate::bake_job::bake_job::BakeJob;
use crate::{PrtError, split_checkpoints};

/// The output of a bake, and the checkpoint beside it, in which results are kept while they are found. Rounds of
/// splitting have files of their own, whose names go on from that of the checkpoint.
#[derive(Clone, Debug)]
pub struct BakeFiles {
    output: PathBuf,
    checkpoint: PathBuf,
}

impl BakeFiles {
    /// The files of a job.
    ///
    /// # Errors
    /// [`PrtError::OfJob`] without an output.
    pub fn of(job: &BakeJob) -> Result<Self, PrtError> {
        let Some(output) = job.output.clone() else {
            return Err(OptionError::new("output", "expected the name of a file").into());
        };
        Ok(match (job.shard.is_some(), job.merge.is_none()) {
            // A shard is what it leaves.
            (true, _) => Self::kept_in(output.clone(), output),
            (false, true) => Self::beside(output),
            // Beside what a bake that was stopped may have kept.
            (false, false) => Self::of_merge(output),
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

    /// The checkpoint of the backs of double-sided surfaces, which are baked after the fronts.
    #[must_use]
    pub fn of_backs(&self) -> Self {
        Self { output: self.output.clone(), checkpoint: appended(&self.checkpoint, ".backs") }
    }

    /// Refuses an output that could not be written, or that is one of the inputs, which would be lost. Clears away what
    /// killed programs have left beside it.
    ///
    /// # Errors
    /// [`PrtError::OfJob`] for an input, [`PrtError::Io`] if the system would refuse.
    pub fn expect_writable(&self, inputs: &[&Path]) -> Result<(), PrtError> {
        let found = self.output.canonicalize();
        let is_same = |input: &&Path| matches!((&found, input.canonicalize()), (Ok(out), Ok(input)) if *out == input);
        if inputs.iter().any(is_same) {
            let message = format!("{} is an input, which would be lost; give another name", self.output.display());
            return Err(OptionError::new("output", message).into());
        }
        check_writable(&self.output).map_err(|source| IoError::io(&self.output, source))?;
        remove_abandoned(&self.output);
        Ok(())
    }

    /// Refuses to begin beside a checkpoint that cannot be of this bake, whose splitting, or else whose bake, would be
    /// in vain.
    pub(crate) fn check_kind(&self, is_split: bool) -> Result<(), PrtError> {
        let rounds = split_checkpoints(&self.checkpoint);
        let (other, does) = match (is_split, rounds.first()) {
            (true, None) if self.checkpoint.exists() => (&self.checkpoint, "does not split"),
            (false, Some(first)) => (first, "splits"),
            _ => return Ok(()),
        };
        let message = format!(
            "{}: this checkpoint is of a bake that {does} triangles; repeat that command to continue it, or start anew \
             with @fresh",
            other.display()
        );
        Err(OptionError::new("", message).into())
    }

    /// Refuses to begin work whose output of `bytes` does not fit on the disk, beside results of `checkpoint` bytes, of
    /// which some may be there already.
    pub(crate) fn check_room(&self, bytes: u64, checkpoint: u64) -> Result<(), PrtError> {
        let there = fs::metadata(&self.checkpoint).map_or(0, |found| found.len());
        expect_room(&self.output, bytes.saturating_add(checkpoint.saturating_sub(there)))?;
        Ok(())
    }

    /// Forgets earlier work.
    pub(crate) fn discard(&self) -> Result<(), PrtError> {
        let rounds = split_checkpoints(&self.checkpoint);
        for path in [&self.checkpoint].into_iter().chain(rounds.iter().rev()).filter(|path| path.exists()) {
            fs::remove_file(path).map_err(|source| IoError::io(path, source))?;
        }
        Ok(())
    }

    /// Removes the files that were kept, when the results are safe. The next bake takes up a file that cannot be removed,
    /// and has nothing left to do.
    pub fn finish(&self) {
        let _ = fs::remove_file(&self.checkpoint);
        self.finish_rounds();
    }

    /// The same of rounds of splitting alone, when the results are safe in the checkpoint itself. The last goes first,
    /// so that what is left by a fault has no gaps.
    pub fn finish_rounds(&self) {
        for path in split_checkpoints(&self.checkpoint).iter().rev() {
            let _ = fs::remove_file(path);
        }
    }

    /// Puts shards together as the checkpoint.
    ///
    /// # Errors
    /// [`PrtError::Io`] for shards of other work, missing ones and those that are there twice.
    pub fn merge(&self, parts: &[PathBuf], job: Job<'_>) -> Result<(), PrtError> {
        let place_of_all = self.checkpoint.display().to_string();
        merge_shards(parts, &self.checkpoint, job).map_err(|error| match error {
            IoError::Invalid { place, message } if place == place_of_all => OptionError::new("merge", message).into(),
            error => error.into(),
        })
    }

    /// The outcome of work that took up shards. Where it failed, their checkpoint is of no use: it is made again in no
    /// time, and would be in the way of other work.
    ///
    /// # Errors
    /// Those of the outcome, of shards that are of other work in words that name the first of them.
    pub fn outcome_of_merge<T>(&self, parts: &[PathBuf], outcome: Result<T, PrtError>) -> Result<T, PrtError> {
        let (Err(error), Some(first)) = (&outcome, parts.first()) else { return outcome };
        let own = self.checkpoint.display().to_string();
        let is_of_checkpoint = match error {
            PrtError::Invalid { place, .. } | PrtError::Io(IoError::Invalid { place, .. }) => *place == own,
            _ => false,
        };
        self.discard()?;
        if !is_of_checkpoint {
            return outcome;
        }
        let message = "this shard and the others are not of this work: the scene, options that decide the numbers, the \
                       version of Lobe or the kind of machine (LOBE_SIMD) differ";
        Err(PrtError::invalid(&first.display().to_string(), message))
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
    fn files_of_all_rounds_are_found_refused_to_others_and_removed() {
        let folder = tempfile::tempdir().unwrap();
        let files = BakeFiles::beside(folder.path().join("out.glb"));
        let make = |names: &[&str]| names.iter().for_each(|name| fs::write(folder.path().join(name), "x").unwrap());
        let rounds = ["out.glb.checkpoint.split-0", "out.glb.checkpoint.split-1"];
        for is_split in [false, true] {
            assert!(files.check_kind(is_split).is_ok(), "nothing is there");
        }
        make(&["out.glb.checkpoint"]);
        let refusal = files.check_kind(true).unwrap_err().to_string();
        assert!(
            refusal.contains("checkpoint: this checkpoint is of a bake that does not split triangles; "),
            "{refusal}"
        );
        make(&rounds);
        let refusal = files.check_kind(false).unwrap_err().to_string();
        assert!(refusal.contains("split-0: this checkpoint is of a bake that splits triangles; "), "{refusal}");
        assert!(files.check_kind(true).is_ok(), "its own files");
        for remove in [BakeFiles::finish, |files: &BakeFiles| files.discard().unwrap()] {
            make(&["out.glb.checkpoint"]);
            make(&rounds);
            remove(&files);
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "files left");
        }
    }

    #[test]
    fn what_no_disk_has_room_for_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let files = BakeFiles::beside(folder.path().join("out.glb"));
        let huge = 1 << 60;
        for (bytes, of_bake) in [(huge, 0), (0, huge), (u64::MAX, u64::MAX)] {
            let refusal = files.check_room(bytes, of_bake).unwrap_err().to_string();
            assert!(refusal.contains("out.glb: expected ") && refusal.contains(" MiB of free space"), "{refusal}");
        }
        assert!(files.check_room(1, 1).is_ok(), "two bytes");
    }
}
