//! The job of an occlusion field, or of the visibility of an entity's own surface.

use std::path::PathBuf;

use lobe_io::{
    Given, GivenPaths, Job, JobFiles, JobOptions, OptionError, OptionField, OptionKind, Shard, SharingOptions,
    WorkOptions, options,
};
use lobe_scene::{EntityKind, Mesh, Scene, SceneSource};
use serde::Serialize;

use crate::error::ShadowError;
use crate::field::bake_field::{
    FieldOptions, FieldReport, VisibilityOptions, bake_field, bake_field_shard, bake_vertex_visibility,
};
use crate::field::field_file::write_field;
use crate::field::field_storage::StorageReport;
use crate::field::visibility_file::{SurfaceVisibility, write_visibility};
use crate::jobs::field_sampling::{COPIES, FieldSampling};
use crate::jobs::storage_options::StorageOptions;

options! {
    /// An occlusion field: an entity, where and how it is sampled, and where the field is written.
    ///
    /// ```
    /// use lobe_io::{Job, JobOptions};
    /// use lobe_shadow::FieldJob;
    ///
    /// let folder = tempfile::tempdir()?;
    /// let output = folder.path().join("ball.safetensors");
    /// let asked = serde_json::json!({
    ///     "scene": "built-in:ball", "spheres": 3, "cells": 4, "rays": 16, "storage": "f16", "output": output,
    /// });
    /// let job = FieldJob::from_values(asked.as_object().cloned().unwrap_or_default())?;
    /// job.run(Job::default())?;
    /// assert!(output.exists());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub struct FieldJob with
        source: SceneSource, sampling: FieldSampling, form: StorageOptions, work: WorkOptions, sharing: SharingOptions
    {
        /// The field, a .safetensors file
        #[serde(serialize_with = "lobe_io::as_text_if_any")]
        output: Option<PathBuf> = None, OptionKind::File, "OUT", "";
        /// Only this entity of a scene: a mesh, or a node of a glTF file, by name or number; in its own frame, which
        /// moves with it, and in the shape that its skin was bound to
        entity: Option<String> = None, OptionKind::Text, "NAME", "";
        /// Rays from each sample point
        rays: u32 = FieldOptions::default().rays,
            OptionKind::Whole { least: 1, most: FieldOptions::MAX_RAYS as u64, what: "a number of rays" }, "N", "";
        /// Another seed gives other rays
        seed: u64 = FieldOptions::default().seed,
            OptionKind::Whole { least: 0, most: u64::MAX, what: "a number" }, "S", "";
        /// Write instead what each vertex sees of the sky past the entity itself: its own visibility, by which those
        /// that other entities leave are multiplied
        self_visibility: bool = false, OptionKind::Flag, "", "";
    }
}

impl JobOptions for FieldJob {
    fn fields() -> Vec<&'static OptionField> {
        let own = SceneSource::fields().into_iter().chain(Self::FIELDS).chain(FieldSampling::FIELDS);
        let own = own.chain(StorageOptions::fields());
        own.chain(WorkOptions::FIELDS).chain(SharingOptions::FIELDS).collect()
    }

    fn heading_of(name: &str) -> Option<&'static str> {
        match name {
            name if SharingOptions::has(name) => SharingOptions::heading_of(name),
            name if StorageOptions::has(name) => StorageOptions::heading_of(name),
            name if SceneSource::has(name) => SceneSource::heading_of(name),
            _ => None,
        }
    }

    fn left_open_of(field: &OptionField) -> &'static str {
        if StorageOptions::has(field.name) { StorageOptions::left_open_of(field) } else { field.left_open }
    }

    fn set_paths(&mut self, given: GivenPaths<'_>) {
        self.source.set_paths(given);
        self.output = given("output").and_then(|paths| paths.into_iter().next()).or(self.output.take());
        self.sharing.set_paths(given);
    }

    fn check_together(&self, given: &Given<'_>) -> Result<(), OptionError> {
        self.source.check_together(given)?;
        self.form.check_together(given)?;
        self.sharing.check_together(given)?;
        self.sampling.check_together(given)?;
        let others = given.first_of(&FieldSampling::OF_POINTS).or(self.sharing.asked());
        if let Some(other) = others.filter(|_| self.self_visibility) {
            let message = format!("not with @{other}; leave one of them out");
            return Err(OptionError::new("self_visibility", message));
        }
        expect_safetensors(self.output.as_ref())
    }
}

/// Refuses an output of another kind.
pub(crate) fn expect_safetensors(output: Option<&PathBuf>) -> Result<(), OptionError> {
    let is_other = |path: &&PathBuf| path.extension().is_none_or(|found| !found.eq_ignore_ascii_case("safetensors"));
    match output.filter(is_other) {
        Some(path) => {
            let message = format!("expected a name that ends in .safetensors, found {}", path.display());
            Err(OptionError::new("output", message))
        }
        None => Ok(()),
    }
}

/// What a job of a field tells of its work.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum FieldDone {
    /// A field.
    Field {
        /// Sample points.
        points: usize,
        /// Those inside the solid.
        inside: usize,
        /// Rays that looked for occlusion.
        rays: u64,
        /// How the numbers are stored.
        storage: StorageReport,
    },
    /// Visibility of the entity's own surface.
    Visibility {
        /// Vertices.
        vertices: usize,
        /// Rays that looked for occlusion.
        rays: u64,
        /// How the numbers are stored.
        storage: StorageReport,
    },
    /// A shard of a field.
    Shard {
        /// Which one.
        shard: Shard,
        /// Its sample points.
        points: usize,
        /// Those of all shards.
        points_in_all: usize,
    },
}

impl FieldJob {
    /// Bakes, and writes the output. Results are kept beside it while they are found; the same job goes on from there.
    /// The job that is watched has the steps `merge` and `bake`, and hears what a user should know.
    ///
    /// # Errors
    /// [`ShadowError::OfJob`] for options that cannot be; [`ShadowError::Cancelled`] if the watch said to stop; else
    /// those of reading, of [`bake_field`] and of writing.
    pub fn run(&self, mut work: Job<'_>) -> Result<FieldDone, ShadowError> {
        self.check()?;
        let files = self.sharing.files(self.output.as_deref())?;
        files.expect_writable(self.sharing.parts().iter().chain([&self.source.scene]).map(PathBuf::as_path))?;
        let scene = self.read(&mut work)?;
        if self.work.fresh {
            files.discard()?;
        }
        if self.self_visibility {
            return self.bake_visibility(&scene, &files, work);
        }
        let options = self.options();
        self.check_memory()?;
        if let Some(shard) = self.sharing.shard {
            let part = work.step("bake").kept_in(files.checkpoint());
            let [points, points_in_all] = bake_field_shard(&scene, &options, shard, part)?;
            return Ok(FieldDone::Shard { shard, points, points_in_all });
        }
        let parts = self.sharing.parts();
        if !parts.is_empty() {
            files.merge(parts, work.step("merge"))?;
        }
        let baked = bake_field(&scene, &options, work.step("bake").kept_in(files.checkpoint()));
        let (field, report) = files.outcome_of_merge(parts, baked)?;
        let storage = write_field(files.output(), &field, &self.form.form())?;
        self.written(&files, &storage, &mut work);
        let FieldReport { points, inside, rays, .. } = report;
        Ok(FieldDone::Field { points, inside, rays, storage })
    }

    /// What hides the sky: the scene, or one entity of it.
    fn read(&self, work: &mut Job<'_>) -> Result<Scene, ShadowError> {
        let name = self.source.name();
        let read = self.source.read_entity(self.entity.as_deref(), self.work.memory().bytes())?;
        read.remarks.iter().for_each(|text| work.note(&name, text));
        if read.is_posed {
            let text = "is posed by animations, skins or morph targets, whose motion this field does not follow; @entity \
                        NAME bakes that of one part in its own frame";
            work.note(&name, text);
        }
        if read.entity.is_some_and(|(_, entity)| entity.kind() == EntityKind::Deformed) {
            let text = "this entity is deformed by a skin or by morph targets, which its field does not follow; spheres of \
                        an @entity do";
            work.note(&name, text);
        }
        Ok(read.scene)
    }

    fn bake_visibility(&self, scene: &Scene, files: &JobFiles, mut work: Job<'_>) -> Result<FieldDone, ShadowError> {
        let (vertices, order) = (scene.vertex_count(), self.sampling.order);
        let what = format!("the visibility of {vertices} vertices at order {order}");
        let numbers = (vertices * order * order) as u64;
        self.work.memory().check(&what, COPIES * size_of::<f32>() as u64 * numbers, "fewer bands (@order)")?;
        let options = VisibilityOptions::default().order(order).rays(self.rays).seed(self.seed);
        let part = work.step("bake").kept_in(files.checkpoint());
        let (rows, rays) = bake_vertex_visibility(scene, &options, part)?;
        let positions = scene.meshes().iter().flat_map(Mesh::positions).copied().collect();
        let visibility = SurfaceVisibility::new(order, rows)?.with_positions(positions)?;
        let storage = write_visibility(files.output(), &visibility, &self.form.form())?;
        self.written(files, &storage, &mut work);
        Ok(FieldDone::Visibility { vertices, rays, storage })
    }

    /// Clears away what is kept, as the results are safe, and says if they could be smaller.
    fn written(&self, files: &JobFiles, storage: &StorageReport, work: &mut Job<'_>) {
        files.finish();
        if let Some(text) = self.form.remark(storage) {
            work.note(&files.output().display().to_string(), &text);
        }
    }

    /// The options of the bake.
    #[must_use]
    pub fn options(&self) -> FieldOptions {
        self.sampling.of_field().rays(self.rays).seed(self.seed)
    }

    fn check_memory(&self) -> Result<(), ShadowError> {
        let (order, points) = (self.sampling.order, self.sampling.points());
        let what = format!("a field of {points} sample points at order {order}");
        Ok(self.work.memory().check(&what, self.sampling.bytes(), "fewer @spheres or @cells")?)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::ops::ControlFlow;
    use std::path::Path;

    use lobe_io::Progress;
    use serde_json::{Value, json};

    use super::*;

    fn job(asked: &Value) -> Result<FieldJob, OptionError> {
        FieldJob::from_values(asked.as_object().unwrap().clone())
    }

    fn ball(output: &Path) -> FieldJob {
        let asked = json!({"scene": "built-in:ball", "spheres": 4, "cells": 4, "rays": 4, "output": output});
        job(&asked).unwrap()
    }

    #[test]
    fn options_that_cannot_be_are_refused_by_name() {
        for (asked, expected) in [
            (json!({"order": 9}), "order: expected an order (number of bands) from 1 to 8, found 9"),
            (json!({"cells": 5}), "cells: expected an even number of cells, found 5"),
            (json!({"spheres": 1}), "spheres: expected a number of spheres from 2 to 256, found 1"),
            (json!({"range": [2, 1]}), "range: expected radii above 0 that rise, found 2,1"),
            (json!({"range": [0, 1]}), "range: expected radii above 0 that rise, found 0,1"),
            (json!({"clusters": 4}), "clusters: only of storage clustered"),
            (json!({"storage": "f64"}), "storage: expected f32, f16, u8 or clustered, found \"f64\""),
            (json!({"self_visibility": true, "cells": 8}), "self_visibility: not with cells"),
            (json!({"self_visibility": true, "shard": "1/2"}), "self_visibility: not with shard"),
            (json!({"shard": "1/2", "merge": ["a"]}), "merge: not with shard"),
            (json!({"output": "a.glb"}), "output: expected a name that ends in .safetensors, found a.glb"),
        ] {
            let error = job(&asked).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{asked}: {error}");
        }
        assert_eq!(FieldJob::default().options(), FieldOptions::default(), "the same defaults");
    }

    #[test]
    fn a_job_that_was_stopped_or_shared_has_the_bytes_of_one_that_was_not() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        ball(&at("alone.safetensors")).run(Job::default()).unwrap();
        let alone = fs::read(at("alone.safetensors")).unwrap();
        let stopped = at("stopped.safetensors");
        let mut steps = Vec::new();
        let mut watch = |progress: &Progress| {
            steps.push(progress.step);
            ControlFlow::Break(())
        };
        let end = ball(&stopped).run(Job::default().watched_by(&mut watch));
        assert!(matches!(end, Err(ShadowError::Cancelled)) && !stopped.exists(), "{end:?}");
        assert_eq!(steps, ["bake"]);
        ball(&stopped).run(Job::default()).unwrap();
        assert!(fs::read(&stopped).unwrap() == alone, "other bytes after a stop");
        let parts = [1, 2].map(|number| {
            let part = at(&format!("{number}.safetensors"));
            ball(&part).sharing(SharingOptions::default().shard(Shard::new(number, 2))).run(Job::default()).unwrap();
            part
        });
        let merge = SharingOptions::default().merge(Some(parts.to_vec()));
        ball(&at("merged.safetensors")).sharing(merge.clone()).run(Job::default()).unwrap();
        assert!(fs::read(at("merged.safetensors")).unwrap() == alone, "other bytes of shards");
        let other = ball(&at("other.safetensors")).seed(1).sharing(merge).run(Job::default()).unwrap_err().to_string();
        assert!(other.contains("1.safetensors: this shard and the others are not of this work"), "{other}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 5, "files left");
    }
}
