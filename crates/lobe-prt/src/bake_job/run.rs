//! A bake from the first to the last.

use std::path::{Path, PathBuf};

use lobe_io::{Job, JobOptions as _, OptionError};

use crate::PrtError;
use crate::bake_job::bake_files::BakeFiles;
use crate::bake_job::bake_job::BakeJob;
use crate::bake_job::open_bake::OpenBake;
use crate::bake_job::prepared_bake::{BakeDone, PreparedBake};

impl BakeJob {
    /// Bakes, and writes the output: what is asked for, or one shard of it, or what is put together of all shards.
    ///
    /// Results are kept beside the output while they are found, and in one file for each round of splitting. A bake that
    /// was stopped, or killed at any moment, goes on from there with the same job, to the same bytes; at the end these
    /// files are removed. The job that is watched has the steps `unwrap`, `merge`, `split`, `bake`, `bake backs`,
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
        let files = BakeFiles::of(self)?;
        self.expect_writable(&files)?;
        // The file of a shard that is done stands alone.
        if !self.fresh && self.shard.is_none() {
            files.check_kind(self.is_split())?;
        }
        Ok(())
    }

    /// Refuses files that cannot be written, or that are read by this job.
    ///
    /// # Errors
    /// Those of [`BakeFiles::expect_writable`].
    pub fn expect_writable(&self, files: &BakeFiles) -> Result<(), PrtError> {
        let parts = self.merge.iter().flatten();
        let inputs: Vec<&Path> = parts.chain([&self.source.scene]).map(PathBuf::as_path).collect();
        files.expect_writable(&inputs)
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
        let files = BakeFiles::of(&job)?;
        if job.fresh {
            files.discard()?;
        }
        let prepared = self.prepared(Some(&files), work.reborrow())?;
        if let Some(shard) = job.shard {
            let done = prepared.write_shard(shard, files.output(), work)?;
            files.finish_rounds();
            return Ok(done);
        }
        if let Some(parts) = &job.merge {
            return prepared.merge(parts, &files, work);
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
    pub fn merge(&self, parts: &[PathBuf], files: &BakeFiles, mut work: Job<'_>) -> Result<BakeDone, PrtError> {
        if let Err(error) = files.merge(parts, work.step("merge")) {
            files.discard()?;
            return Err(error);
        }
        let done = files.outcome_of_merge(parts, self.write(files, work))?;
        files.finish();
        Ok(done)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::ops::ControlFlow;

    use lobe_io::{Progress, Shard};
    use serde_json::{Value, json};

    use super::*;

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
            ball(&part).shard(Shard::new(number, 2)).run(Job::default()).unwrap();
            part
        });
        ball(&at("merged.glb")).merge(Some(parts.to_vec())).run(Job::default()).unwrap();
        assert!(fs::read(at("merged.glb")).unwrap() == fs::read(at("alone.glb")).unwrap(), "other bytes");
        let other =
            ball(&at("other.glb")).order(3).merge(Some(parts.to_vec())).run(Job::default()).unwrap_err().to_string();
        assert!(other.contains("1.safetensors: this shard and the others are not of this work"), "{other}");
        let expected = ["1.safetensors", "2.safetensors", "alone.glb", "merged.glb"];
        assert_eq!(names_in(folder.path()), expected, "files left");
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
            (json!({"output": "a.glb", "mode": "glossy"}), "output: mode glossy and grid are written as .safetensors"),
            (json!({"output": "a.exr"}), "output: a.exr: expected a name that ends in .glb or .safetensors"),
            (json!({"output": "a.glb", "shard": "1/2"}), "output: a.glb: expected a name that ends in .safetensors"),
            (json!({"up": "z"}), "up: only .obj and .ply files"),
        ] {
            let error = refused(asked.clone());
            assert!(error.starts_with(expected), "{asked}: {error}");
        }
    }
}
