//! A bake from the first to the last.

use std::path::PathBuf;

use lobe_io::{Job, JobFiles, JobOptions as _, OptionError};

use crate::bake_job::bake_job::BakeJob;
use crate::bake_job::open_bake::OpenBake;
use crate::bake_job::prepared_bake::{BakeDone, PreparedBake};
use crate::error::PrtError;

impl BakeJob {
    /// Bakes, and writes the output: what is asked for, or one shard of it, or what is put together of all shards.
    ///
    /// Results are kept beside the output while they are found, and in one file for each round of splitting. A bake that
    /// was stopped, or killed at any moment, goes on from there with the same job, to the same bytes; at the end these
    /// files are removed. The job that is watched has the steps `unwrap`, `merge`, `split`, `bake`, `bake backs`,
    /// `bake direct`,
    /// `compress` and `write`, and hears what a user should know.
    ///
    /// # Errors
    /// [`PrtError::OfJob`] for options that cannot be, or not of this scene; [`PrtError::Cancelled`] if the watch said
    /// to stop; else those of reading, baking and writing.
    pub fn run(&self, mut work: Job<'_>) -> Result<BakeDone, PrtError> {
        self.begin()?;
        OpenBake::read(self.clone(), work.reborrow())?.run(work)
    }

    /// Refuses options and files that cannot be, before anything is read.
    ///
    /// # Errors
    /// [`PrtError::OfJob`] and [`PrtError::Io`].
    pub fn begin(&self) -> Result<(), PrtError> {
        self.check()?;
        if self.source.scene.as_os_str().is_empty() {
            return Err(OptionError::new("scene", "expected the scene that is baked").into());
        }
        let files = self.files()?;
        self.expect_writable(&files)?;
        // The file of a shard that is done stands alone.
        if !self.work.fresh && self.sharing.shard.is_none() {
            expect_own_kind(&files, self.is_split())?;
        }
        Ok(())
    }

    /// Refuses files that cannot be written, or that are read by this job.
    ///
    /// # Errors
    /// Those of [`JobFiles::expect_writable`].
    pub fn expect_writable(&self, files: &JobFiles) -> Result<(), PrtError> {
        let parts = self.sharing.parts().iter();
        Ok(files.expect_writable(parts.chain([&self.source.scene]).map(PathBuf::as_path))?)
    }

    /// The output, and what is kept beside it.
    ///
    /// # Errors
    /// [`PrtError::OfJob`] without an output.
    pub fn files(&self) -> Result<JobFiles, PrtError> {
        Ok(self.sharing.files(self.output.as_deref())?)
    }
}

impl OpenBake {
    /// Bakes the scene that was read, and writes the output, as [`BakeJob::run`] does.
    ///
    /// # Errors
    /// Those of [`BakeJob::run`].
    pub fn run(self, mut work: Job<'_>) -> Result<BakeDone, PrtError> {
        self.job.begin()?;
        let job = self.job.clone();
        let files = job.files()?;
        if job.work.fresh {
            files.discard()?;
        }
        let prepared = self.prepared(Some(&files), work.reborrow())?;
        if let Some(shard) = job.sharing.shard {
            let done = prepared.write_shard(shard, files.output(), work)?;
            files.finish_rounds();
            return Ok(done);
        }
        if job.sharing.merge.is_some() {
            return prepared.merge(job.sharing.parts(), &files, work);
        }
        let done = prepared.write_last(&files, work)?;
        files.finish();
        Ok(done)
    }
}

impl PreparedBake {
    /// Puts all shards together and writes the output: the bytes that one machine alone gives it.
    ///
    /// # Errors
    /// [`PrtError::Invalid`] for shards of other work, [`PrtError::Io`] for missing ones and those that are there twice;
    /// else those of [`PreparedBake::write`].
    pub fn merge(&self, parts: &[PathBuf], files: &JobFiles, mut work: Job<'_>) -> Result<BakeDone, PrtError> {
        if let Err(error) = files.merge(parts, work.step("merge")) {
            files.discard()?;
            return Err(error.into());
        }
        let done = files.outcome_of_merge(parts, self.write(files, work))?;
        files.finish();
        Ok(done)
    }
}

/// Refuses to begin beside a checkpoint that cannot be of this bake, whose splitting, or else whose bake, would be in
/// vain.
fn expect_own_kind(files: &JobFiles, is_split: bool) -> Result<(), PrtError> {
    let rounds = files.rounds();
    let (other, does) = match (is_split, rounds.first()) {
        (true, None) if files.checkpoint().exists() => (files.checkpoint(), "does not split"),
        (false, Some(first)) => (first.as_path(), "splits"),
        _ => return Ok(()),
    };
    let message = format!(
        "{}: this checkpoint is of a bake that {does} triangles; repeat that command to continue it, or start anew with \
         @fresh",
        other.display()
    );
    Err(OptionError::new("", message).into())
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::ops::ControlFlow;
    use std::path::Path;

    use lobe_io::{Progress, Shard, SharingOptions};
    use lobe_scene::SceneReadOptions;
    use serde_json::{Value, json};

    use super::*;
    use crate::bake::options::BakeMode;
    use crate::files::read_baked::read_baked;
    use crate::transfer::transfer_parts::TransferParts;

    fn job(asked: Value) -> BakeJob {
        let Value::Object(values) = asked else { panic!("expected a table") };
        BakeJob::from_values(values).unwrap()
    }

    fn ball(output: &Path) -> BakeJob {
        job(json!({"scene": "built-in:ball", "order": 2, "samples": 4, "max_vertices": 14100, "output": output}))
    }

    fn names_in(folder: &Path) -> Vec<String> {
        let name = |found: std::io::Result<fs::DirEntry>| found.unwrap().file_name().into_string().unwrap();
        let mut all: Vec<String> = fs::read_dir(folder).unwrap().map(name).collect();
        all.sort();
        all
    }

    #[test]
    fn a_bake_does_not_begin_beside_the_files_of_one_that_splits_or_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let files = JobFiles::beside(folder.path().join("out.glb"));
        let make = |name: &str| fs::write(folder.path().join(name), "x").unwrap();
        for is_split in [false, true] {
            assert!(expect_own_kind(&files, is_split).is_ok(), "nothing is there");
        }
        make("out.glb.checkpoint");
        let refusal = expect_own_kind(&files, true).unwrap_err().to_string();
        assert!(
            refusal.contains("checkpoint: this checkpoint is of a bake that does not split triangles; "),
            "{refusal}"
        );
        make("out.glb.checkpoint.split-0");
        let refusal = expect_own_kind(&files, false).unwrap_err().to_string();
        assert!(refusal.contains("split-0: this checkpoint is of a bake that splits triangles; "), "{refusal}");
        assert!(expect_own_kind(&files, true).is_ok(), "its own files");
    }

    #[test]
    fn a_job_that_was_stopped_at_any_step_goes_on_to_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("ball.glb");
        let mut steps = Vec::new();
        let mut watch = |progress: &Progress| {
            steps.push(progress.step);
            ControlFlow::Continue(())
        };
        ball(&output).run(Job::default().watched_by(&mut watch)).unwrap();
        steps.dedup();
        assert_eq!(steps, ["split", "bake", "write"]);
        let whole = fs::read(&output).unwrap();
        fs::remove_file(&output).unwrap();
        for stop in ["split", "bake", "write"] {
            let mut watch = |progress: &Progress| match progress.step == stop && progress.done > 0 {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            };
            let stopped = ball(&output).run(Job::default().watched_by(&mut watch));
            assert!(matches!(stopped, Err(PrtError::Cancelled)), "{stop}: {stopped:?}");
            assert!(!output.exists(), "{stop}: half an output");
        }
        ball(&output).run(Job::default()).unwrap();
        assert!(fs::read(&output).unwrap() == whole, "other bytes than without a stop");
        assert_eq!(names_in(folder.path()), ["ball.glb"], "files left");
    }

    #[test]
    fn shards_of_a_job_come_together_to_the_bytes_of_one_machine() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        ball(&at("alone.glb")).run(Job::default()).unwrap();
        let parts = [1, 2].map(|number| {
            let part = at(&format!("{number}.safetensors"));
            ball(&part).sharing(SharingOptions::default().shard(Shard::new(number, 2))).run(Job::default()).unwrap();
            part
        });
        let merge = SharingOptions::default().merge(Some(parts.to_vec()));
        ball(&at("merged.glb")).sharing(merge.clone()).run(Job::default()).unwrap();
        assert!(fs::read(at("merged.glb")).unwrap() == fs::read(at("alone.glb")).unwrap(), "other bytes");
        let other = ball(&at("other.glb")).order(3).sharing(merge).run(Job::default()).unwrap_err().to_string();
        assert!(other.contains("1.safetensors: this shard and the others are not of this work"), "{other}");
        let expected = ["1.safetensors", "2.safetensors", "alone.glb", "merged.glb"];
        assert_eq!(names_in(folder.path()), expected, "files left");
    }

    #[test]
    fn the_direct_part_of_a_file_has_the_paths_of_the_whole() {
        let folder = tempfile::tempdir().unwrap();
        let bake = |name: &str, mode: BakeMode, parts: TransferParts| {
            let path = folder.path().join(name);
            let asked = json!({"scene": "built-in:ball", "order": 2, "samples": 4, "no_split": true, "output": path});
            job(asked).mode(mode).parts(parts).run(Job::default()).unwrap();
            read_baked(&path, &SceneReadOptions::default()).unwrap()
        };
        let whole = bake("whole.glb", BakeMode::Interreflected, TransferParts::Whole);
        let shadowed = bake("shadowed.glb", BakeMode::Shadowed, TransferParts::Whole);
        let both = bake("both.glb", BakeMode::Interreflected, TransferParts::DirectAndReflected);
        assert_eq!((both.transfer, both.direct), (whole.transfer.clone(), Some(shadowed.transfer)), "both");
        assert!(whole.direct.is_none() && both.recipe.parts == Some(TransferParts::DirectAndReflected), "recipe");
        assert_eq!(names_in(folder.path()), ["both.glb", "shadowed.glb", "whole.glb"], "files left");
    }

    #[test]
    fn options_that_exclude_each_other_are_refused_by_name() {
        let refused = |asked: Value| {
            let Value::Object(mut values) = asked else { panic!("expected a table") };
            values.insert("scene".to_owned(), json!("built-in:ball"));
            BakeJob::from_values(values).unwrap_err().to_string()
        };
        for (asked, expected) in [
            (json!({"order": 9}), "order: expected an order (number of bands) from 1 to 8, found 9"),
            (json!({"mode": "shadowed", "bounces": 3}), "bounces: only of mode interreflected and glossy"),
            (json!({"mode": "glossy", "grid": [2, 2, 2]}), "mode: glossy light is at vertices only"),
            (json!({"mode": "glossy", "albedo": "none"}), "albedo: matrices never have the albedo"),
            (json!({"mode": "glossy", "weights": 8}), "weights: of transfer vectors only"),
            (json!({"texels": 8, "grid": [2, 2, 2]}), "grid: not with texels"),
            (json!({"texels": 8, "max_edge": 1.0}), "max_edge: light is not at vertices"),
            (json!({"texels": 8, "clusters": 4}), "clusters: of transfer at vertices, not of texels"),
            (json!({"grid_box": [0, 0, 0, 1, 1, 1]}), "grid_box: only with grid"),
            (json!({"padding": 2}), "padding: only with texels"),
            (json!({"no_split": true, "min_edge": 1.0}), "min_edge: not with no_split"),
            (json!({"shard": "1/2", "merge": ["a"]}), "merge: not with shard"),
            (json!({"shard": "3/2"}), "shard: expected a part I/N, such as 1/4"),
            (json!({"backs": true, "clusters": 2}), "backs: not with clusters"),
            (json!({"backs": true, "output": "a.safetensors"}), "backs: only of a .glb"),
            (json!({"parts": "direct,reflected", "clusters": 2}), "parts: not with clusters"),
            (json!({"parts": "direct,reflected", "mode": "shadowed"}), "parts: only of mode interreflected"),
            (json!({"parts": "direct,reflected", "output": "a.safetensors"}), "parts: only of a .glb"),
            (json!({"output": "a.glb", "mode": "glossy"}), "output: mode glossy and grid are written as .safetensors"),
            (json!({"output": "a.exr"}), "output: a.exr: expected a name that ends in .glb or .safetensors"),
            (json!({"output": "a.glb", "shard": "1/2"}), "output: a.glb: expected a name that ends in .safetensors"),
            (json!({"up": "z"}), "up: only .obj or .ply files"),
        ] {
            let error = refused(asked.clone());
            assert!(error.starts_with(expected), "{asked}: {error}");
        }
    }
}
