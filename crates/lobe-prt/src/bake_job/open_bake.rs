//! The scene of a bake: read, split along its long edges, and unwrapped where that is asked for.

use std::sync::Arc;

use lobe_io::{Job, JobOptions as _, OptionError};
use lobe_scene::{GltfDocument, Mesh, Scene, ScenePose};

use crate::bake::options::BakeMode;
use crate::bake_job::bake_job::{BakeJob, ends_in};
use crate::bake_job::lightmap_scene::{LightmapScene, lightmap_scene};
use crate::bake_work::BakeWork;
use crate::error::PrtError;
use crate::files::baked_glb::BakedGlb;
use crate::fit::adaptive::{AdaptiveOptions, AdaptiveReport};
use crate::receivers::texel_receivers::TexelReceivers;

/// A bake whose scene is read.
#[derive(Debug)]
pub struct OpenBake {
    pub(crate) job: BakeJob,
    pub(crate) scene: Arc<Scene>,
    /// All that a glTF file holds beside the scene, if the output keeps it.
    pub(crate) document: Option<GltfDocument>,
    /// The pose of the scene, if its file poses it.
    pub(crate) pose: Option<ScenePose>,
    pub(crate) lightmap: LightmapScene,
}

/// How a scene was split where transfer is off, and what came of it.
pub(crate) type SplitBy = (AdaptiveOptions, AdaptiveReport);

impl OpenBake {
    /// Reads the scene of a job, and splits or unwraps it where that takes no rays.
    ///
    /// # Errors
    /// [`PrtError::OfJob`] for options that cannot be; those of [`SceneSource::read`](lobe_scene::SceneSource::read),
    /// [`Scene::split_edges`] and [`Scene::unwrapped`].
    pub fn read(job: BakeJob, mut work: Job<'_>) -> Result<Self, PrtError> {
        job.check()?;
        let name = job.source.name();
        // A .glb keeps what a glTF file holds beside the scene; without an output nobody knows yet.
        let keeps_document = job.is_glb() || job.output.is_none();
        // A scene that is unwrapped is written anew, with its materials.
        let source = job.source.clone().finish(keeps_document && job.texels.is_some());
        let read = source.read(job.memory().bytes(), keeps_document)?;
        read.remarks.iter().for_each(|text| work.note(&name, text));
        tell_of_normal_maps(&job, &read.scene, &mut work);
        let scene = match job.max_edge {
            Some(max_edge) => read.scene.split_edges(max_edge as f32)?,
            None => read.scene,
        };
        let (scene, document, lightmap) = match job.texels {
            Some(width) => {
                let (scene, lightmap) = lightmap_scene(&job, (scene, read.document), width, work)?;
                (scene, None, lightmap)
            }
            None => (scene, read.document, LightmapScene::default()),
        };
        Ok(Self { job, scene: Arc::new(scene), document, pose: read.pose, lightmap })
    }

    /// The job.
    #[must_use]
    pub fn job(&self) -> &BakeJob {
        &self.job
    }

    /// The points that are asked for in a scene, and what is baked there.
    pub(crate) fn work(&self, scene: Arc<Scene>) -> Result<BakeWork, PrtError> {
        let (job, light) = (&self.job, self.job.light(&scene));
        if let Some(counts) = job.grid {
            return BakeWork::in_grid(scene, counts, job.grid_box, light).map_err(|error| match error {
                PrtError::Options(message) => {
                    OptionError::new("grid", format!("{message}; @grid_box asks for another")).into()
                }
                error => error,
            });
        }
        if let Some(width) = job.texels {
            self.check_memory_of_texels(&scene, width)?;
            let work = BakeWork::at_texels(scene, width, light)?;
            return Ok(work.finished_by(job.finishing()).unwrapped_by(self.lightmap.options.clone()));
        }
        BakeWork::at_vertices(scene, light)
    }

    /// Refuses a lightmap that takes too much memory, more as an .exr.
    fn check_memory_of_texels(&self, scene: &Scene, width: usize) -> Result<(), PrtError> {
        let job = &self.job;
        let channels = job.light(scene).channels_for(scene, scene.is_gray());
        let texels = (width as u64).saturating_pow(2);
        let numbers = texels.saturating_mul((job.order.pow(2) * channels.count()) as u64);
        // Of a picture all numbers, and the file while it grows.
        let is_exr = job.output.as_deref().is_some_and(|output| ends_in(output, "exr"));
        let picture = if is_exr { 8 * numbers } else { 0 };
        let finish = if job.finishing().is_asked() { TexelReceivers::BYTES_TO_FINISH * numbers } else { 0 };
        let bytes = (picture + finish).saturating_add(TexelReceivers::bytes_for(width));
        let what = format!("@texels {width}");
        job.memory().check(&what, bytes, "fewer @texels, or a lower @order")?;
        Ok(())
    }

    /// Refuses a .glb that cannot be, before the scene is split.
    pub(crate) fn check_glb(&self) -> Result<(), PrtError> {
        if self.job.is_glb() {
            self.check_document(&self.scene)?;
            self.glb(self.document.clone(), &self.scene)?;
        }
        Ok(())
    }

    /// The scene that the results become part of, with all that its document holds.
    pub(crate) fn glb(&self, document: Option<GltfDocument>, scene: &Scene) -> Result<BakedGlb, PrtError> {
        match document {
            Some(document) => BakedGlb::of_document(document, scene)
                .map_err(|error| OptionError::new("", format!("{}: {error}", self.job.source.name())).into()),
            None => Ok(BakedGlb::of_scene(scene)),
        }
    }

    /// Refuses meshes that are too many for a .glb, which has an accessor for each attribute of each of them.
    pub(crate) fn check_document(&self, scene: &Scene) -> Result<(), PrtError> {
        /// A million meshes of one triangle took 9.35 GB at order 1, with four accessors each.
        const BYTES_OF_ACCESSOR: u64 = 2340;
        let channels = self.job.light(scene).channels_for(scene, scene.is_gray());
        // Positions, normals and triangles, what else a mesh has, and four numbers of transfer each.
        let transfer = (self.job.order.pow(2) * channels.count()).div_ceil(4);
        let accessors_of = |mesh: &Mesh| {
            let uvs = [0, 1].map(|set| mesh.uvs(set).is_empty());
            let is_missing = [mesh.tangents().is_empty(), uvs[0], uvs[1], mesh.colors().is_empty()];
            3 + is_missing.into_iter().filter(|is_missing| !is_missing).count() + transfer
        };
        let accessors: usize = scene.meshes().iter().map(accessors_of).sum();
        let what = format!("a .glb of {} meshes", scene.meshes().len());
        let instead = "fewer instances, or a .safetensors file";
        self.job.memory().check(&what, BYTES_OF_ACCESSOR * accessors as u64, instead)?;
        Ok(())
    }
}

/// Says that transfer at vertices leaves the normal maps of their surfaces out, if there are any. The view that glossy
/// surfaces mirror is tilted by them where it is looked up.
fn tell_of_normal_maps(job: &BakeJob, scene: &Scene, work: &mut Job<'_>) {
    if !job.is_elsewhere() && job.mode != BakeMode::Glossy && scene.has_normal_maps() {
        let text = "has normal maps, which transfer at vertices does not hold; @texels bakes at texels, where it does";
        work.note(&job.source.name(), text);
    }
}

/// The outcome of splitting where transfer is off, and what is left to do.
pub(crate) fn note_of_split(scene: &Scene, (options, report): (&AdaptiveOptions, &AdaptiveReport)) -> String {
    let AdaptiveReport { vertices_before, vertices, error, error_bound, too_short, worst, .. } = report;
    let text =
        format!("{vertices} vertices after splitting, {vertices_before} before; interpolated transfer is off by");
    if *error_bound <= options.error {
        return format!("{text} less than {:.1} %", 100.0 * options.error);
    }
    // An estimate near zero says little: half of its bound is nearer to what is known.
    let error = error.max(0.5 * error_bound);
    let place = worst.map_or_else(String::new, |(mesh, _)| format!(", most on `{}`", scene.meshes()[mesh].name()));
    let advice = if *too_short > 0.5 {
        "a smaller @min_edge splits what is too short now".to_owned()
    } else {
        // Along the edge of a shadow the error falls as the root of the number of vertices.
        format!("@max_vertices {} about halves it", 4 * vertices)
    };
    format!("{text} about {:.1} %{place}; {advice}", 100.0 * error)
}

#[cfg(test)]
mod tests {
    use lobe_scene::built_in;

    use super::*;

    #[test]
    fn the_note_after_splitting_says_what_is_off_and_what_to_do() {
        let scene = built_in::ball_over_ground(4);
        let options = AdaptiveOptions::default().error(0.02);
        let mut report = AdaptiveReport::default();
        (report.vertices_before, report.vertices, report.error, report.error_bound) = (8, 20, 0.01, 0.015);
        let begin = "20 vertices after splitting, 8 before; interpolated transfer is off by";
        assert_eq!(note_of_split(&scene, (&options, &report)), format!("{begin} less than 2.0 %"));
        (report.error, report.error_bound, report.worst) = (0.041, 0.05, Some((1, 0.9)));
        let name = scene.meshes()[1].name();
        let expected = format!("{begin} about 4.1 %, most on `{name}`; @max_vertices 80 about halves it");
        assert_eq!(note_of_split(&scene, (&options, &report)), expected);
        report.too_short = 0.8;
        let note = note_of_split(&scene, (&options, &report));
        assert!(note.ends_with("a smaller @min_edge splits what is too short now"), "{note}");
    }
}
