//! A bake that is ready: what is baked at which points, and the file that waits for it.

use std::path::Path;
use std::sync::Arc;

use lobe_io::{Job, JobFiles, OptionError, Progress, Shard};
use lobe_scene::GltfDocument;

use crate::bake::options::BakeReport;
use crate::bake_job::bake_job::{BakeJob, ends_in};
use crate::bake_job::open_bake::{OpenBake, SplitBy, note_of_split};
use crate::bake_work::{BakeWork, BakedRows};
use crate::compression::compress::{CompressOptions, CompressReport};
use crate::compression::compressed_transfer::CompressedTransfer;
use crate::error::PrtError;
use crate::files::baked_backs::double_sided_vertices;
use crate::files::baked_glb::{BakedGlb, MoreTransfer};
use crate::files::compressed_file::write_compressed_transfer;
use crate::files::lightmap_glb::LightmapGlb;
use crate::fit::adaptive::AdaptiveReport;
use crate::fit::fitted_vertices::FittedVertices;
use crate::recipe::Recipe;
use crate::transfer::transfer::Transfer;
use crate::transfer::transfer_parts::TransferParts;
use crate::transfer::transfer_rows::TransferRows;

/// A bake whose scene and points are known.
#[derive(Debug)]
pub struct PreparedBake {
    pub(crate) open: OpenBake,
    pub(crate) work: BakeWork,
    pub(crate) split: Option<SplitBy>,
}

/// What a bake that is written tells of itself.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct BakeDone {
    /// Vertices of the scene, once it is split.
    pub vertices: usize,
    /// Its triangles.
    pub triangles: usize,
    /// Points that are baked in all; a shard has a part of them.
    pub points: usize,
    /// The bake.
    pub report: BakeReport,
    /// How the scene was split where transfer is off, if it was.
    pub split: Option<AdaptiveReport>,
    /// How transfer was compressed, if it was.
    pub compression: Option<CompressReport>,
}

impl OpenBake {
    /// Splits triangles where transfer is off, unless the options say otherwise, with rounds kept beside the output if
    /// there is one. Refuses work whose results could not be stored before it begins.
    ///
    /// # Errors
    /// Those of [`BakeWork::at_vertices`] and its like, [`split_adaptively`](crate::split_adaptively) and
    /// [`BakedGlb::check_size`]; [`PrtError::OfJob`] for a grid or a lightmap that cannot be, and for what takes more
    /// memory than allowed.
    pub fn prepared(mut self, files: Option<&JobFiles>, mut work: Job<'_>) -> Result<PreparedBake, PrtError> {
        if let Some(note) = self.lightmap.note.take() {
            work.note(&self.job.source.name(), &note);
        }
        if !self.job.is_split() {
            let points = self.work(Arc::clone(&self.scene))?;
            return Ok(PreparedBake { open: self, work: points, split: None });
        }
        self.check_glb()?;
        let light = self.job.light(&self.scene);
        let whole = BakeWork::at_vertices(Arc::clone(&self.scene), light.clone())?;
        if self.job.is_glb() {
            BakedGlb::of_scene(&self.scene).check_size(self.job.order, whole.channels())?;
        }
        let mut part = work.step("split");
        if let Some(files) = files {
            files.expect_room(whole.file_bytes(), whole.bytes())?;
            part = part.kept_in(files.checkpoint());
        }
        let options = self.job.splitting(&self.scene, light)?;
        let (split, report) = whole.split(&options, part)?;
        work.note(&self.job.source.name(), &note_of_split(&split, (&options, &report)));
        drop(whole);
        // The scene that was read is of no more use.
        self.scene = Arc::new(split);
        let points = self.work(Arc::clone(&self.scene))?;
        Ok(PreparedBake { open: self, work: points, split: Some((options, report)) })
    }
}

impl PreparedBake {
    /// The job.
    #[must_use]
    pub fn job(&self) -> &BakeJob {
        &self.open.job
    }

    /// What is baked at which points.
    #[must_use]
    pub fn work(&self) -> &BakeWork {
        &self.work
    }

    /// Bakes a shard, which is the file that it is kept in.
    ///
    /// # Errors
    /// Those of [`BakeWork::bake_shard`].
    pub fn write_shard(&self, shard: Shard, output: &Path, mut work: Job<'_>) -> Result<BakeDone, PrtError> {
        let report = self.work.bake_shard(shard, work.step("bake").kept_in(output))?;
        Ok(self.done(report, None))
    }

    /// Bakes everything, or takes it from the checkpoint, and writes the output.
    ///
    /// # Errors
    /// Those of [`BakeWork::bake`] and of writing; [`PrtError::OfJob`] for compression of matrices.
    pub fn write(&self, files: &JobFiles, work: Job<'_>) -> Result<BakeDone, PrtError> {
        self.write_with(self.open.document.clone(), files, work)
    }

    /// [`PreparedBake::write`] for the last time: all that the scene's file holds is in memory once.
    ///
    /// # Errors
    /// Those of [`PreparedBake::write`].
    pub fn write_last(mut self, files: &JobFiles, work: Job<'_>) -> Result<BakeDone, PrtError> {
        let document = self.open.document.take();
        self.write_with(document, files, work)
    }

    fn write_with(
        &self,
        document: Option<GltfDocument>,
        files: &JobFiles,
        mut work: Job<'_>,
    ) -> Result<BakeDone, PrtError> {
        // Prepare the output except for the transfer, so that its faults show before the bake.
        let glb = self.glb(document, files.output())?;
        let (scene, channels, order) = (self.work.scene(), self.work.channels(), self.open.job.order);
        if let Some(glb) = self.lightmap_glb(files.output()) {
            glb.check_size(order, channels)?;
        }
        let size = glb.as_ref().map_or_else(|| self.work.file_bytes(), |glb| glb.size(order, channels));
        files.expect_room(size, self.work.bytes())?;
        // Bake, into the checkpoint.
        let (baked, report) = self.work.bake(work.step("bake").kept_in(files.checkpoint()))?;
        let recipe = self.recipe(&report);
        if let (Some(glb), Some(transfer)) = (&glb, baked.as_transfer())
            && (self.open.job.backs || self.is_parted())
        {
            let (backs, direct) = (self.backs(files, work.reborrow())?, self.direct(files, &report, work.reborrow())?);
            let more = MoreTransfer {
                backs: backs.as_ref().map(|(backs, _)| backs as &dyn TransferRows),
                direct: direct.as_ref().map(|(direct, _)| direct as &dyn TransferRows),
            };
            let recipe = if backs.is_some() { recipe.backs(true) } else { recipe };
            glb.write_with(files.output(), transfer, more, &recipe, work.step("write"))?;
            backs.iter().chain(&direct).for_each(|(_, kept)| kept.finish());
            return Ok(self.done(report, None));
        }
        // Write the results as they are, unless they are to be compressed.
        let compression = match self.open.job.compression() {
            None => {
                self.write_plain(files.output(), (glb.as_ref(), &baked), &recipe, work.step("write"))?;
                None
            }
            Some(options) => {
                let made = (glb, baked);
                Some(self.write_compressed(files.output(), made, &options, (recipe, work.reborrow()))?)
            }
        };
        if self.is_without_split_mesh(files.output()) {
            let vertices = scene.vertex_count();
            let text = format!("transfer of {vertices} vertices after splitting; only a .glb holds the split mesh");
            work.note(&files.output().display().to_string(), &text);
        }
        Ok(self.done(report, compression))
    }

    /// Whether the vertices of the output are in no file.
    fn is_without_split_mesh(&self, output: &Path) -> bool {
        (self.split.is_some() || self.open.job.asks_to_split()) && !ends_in(output, "glb")
    }

    fn done(&self, report: BakeReport, compression: Option<CompressReport>) -> BakeDone {
        let scene = self.work.scene();
        BakeDone {
            vertices: scene.vertex_count(),
            triangles: scene.triangle_count(),
            points: self.work.points(),
            report,
            split: self.split.as_ref().map(|(_, report)| report.clone()),
            compression,
        }
    }

    /// The scene that the results become part of, which has to have room for them; none of other outputs, and of texels,
    /// whose .glb is that of the lightmap.
    fn glb(&self, document: Option<GltfDocument>, output: &Path) -> Result<Option<BakedGlb>, PrtError> {
        let job = &self.open.job;
        if !ends_in(output, "glb") {
            return Ok(None);
        }
        let scene = self.work.scene();
        self.open.check_document(scene)?;
        if job.texels.is_some() {
            return Ok(None);
        }
        let glb = self.open.glb(document, scene)?;
        let glb = if job.backs { glb.with_backs(scene) } else { glb };
        let glb = if self.is_parted() { glb.with_direct(self.work.channels()) } else { glb };
        glb.check_size(job.order, self.work.channels())?;
        Ok(Some(glb))
    }

    /// The .glb that waits for texels, if that is the output.
    fn lightmap_glb(&self, output: &Path) -> Option<&LightmapGlb> {
        self.open.lightmap.glb.as_ref().filter(|_| ends_in(output, "glb"))
    }

    fn write_plain(
        &self,
        output: &Path,
        (glb, baked): (Option<&BakedGlb>, &BakedRows),
        recipe: &Recipe,
        work: Job<'_>,
    ) -> Result<(), PrtError> {
        match (glb, baked.as_transfer()) {
            (Some(glb), Some(transfer)) => glb.write(output, transfer, recipe, work),
            _ => match self.lightmap_glb(output) {
                Some(glb) => self.work.write_into_glb(output, (glb, baked), recipe, work),
                None => self.work.write(output, baked, recipe, work),
            },
        }
    }

    fn write_compressed(
        &self,
        output: &Path,
        (glb, baked): (Option<BakedGlb>, BakedRows),
        options: &CompressOptions,
        (recipe, mut work): (Recipe, Job<'_>),
    ) -> Result<CompressReport, PrtError> {
        let Some(loaded) = baked.into_transfer()? else {
            return Err(OptionError::new("clusters", "of transfer vectors only, not of matrices").into());
        };
        let (compressed, saved) = CompressedTransfer::new(&loaded, options, work.step("compress"))?;
        if work.step("write").report(&Progress { total: 1, ..Progress::default() }).is_break() {
            return Err(PrtError::Cancelled);
        }
        let recipe = recipe.relative_error(saved.relative_error);
        match glb {
            Some(glb) => glb.write_compressed(output, &compressed, &recipe)?,
            None => write_compressed_transfer(output, &compressed, &recipe)?,
        }
        Ok(saved)
    }

    /// Whether the direct part of the transfer is in the file, too.
    fn is_parted(&self) -> bool {
        self.open.job.parts == TransferParts::DirectAndReflected
    }

    /// The direct part of the transfer, by the paths of the whole, and the files that it is kept in; none if it is not
    /// asked for.
    fn direct(
        &self,
        whole: &JobFiles,
        report: &BakeReport,
        mut work: Job<'_>,
    ) -> Result<Option<(Transfer, JobFiles)>, PrtError> {
        if !self.is_parted() {
            return Ok(None);
        }
        let files = whole.of_part(".direct");
        if self.open.job.work.fresh {
            files.discard()?;
        }
        let options = self.work.options().clone().of_direct_part(Some(report.samples));
        let vertices = FittedVertices::all(self.work.scene())?;
        let (direct, _) =
            vertices.bake(self.work.bvh(), &options, work.step("bake direct").kept_in(files.checkpoint()))?;
        Ok(Some((direct, files)))
    }

    /// The transfer of the backs of all double-sided vertices, and the files that it is kept in; none of a scene without
    /// any, or if they are not asked for.
    fn backs(&self, fronts: &JobFiles, mut work: Job<'_>) -> Result<Option<(Transfer, JobFiles)>, PrtError> {
        if !self.open.job.backs {
            return Ok(None);
        }
        let scene = self.work.scene();
        let vertices = double_sided_vertices(scene);
        if vertices.is_empty() {
            let text = "has no double-sided surfaces, so that @backs adds nothing";
            work.note(&self.open.job.source.name(), text);
            return Ok(None);
        }
        let files = fronts.of_part(".backs");
        if self.open.job.work.fresh {
            files.discard()?;
        }
        let options = self.work.options().clone().channels(Some(self.work.channels()));
        let vertices = FittedVertices::backs(scene, &vertices)?;
        let (backs, _) =
            vertices.bake(self.work.bvh(), &options, work.step("bake backs").kept_in(files.checkpoint()))?;
        Ok(Some((backs, files)))
    }

    /// Everything that decides the bytes of the output, and nothing that differs from run to run.
    fn recipe(&self, report: &BakeReport) -> Recipe {
        let (job, compression) = (&self.open.job, self.open.job.compression());
        let recipe = self.work.recipe(report);
        let recipe = self.split.iter().fold(recipe, |recipe, (options, report)| recipe.split_by(options, report));
        let recipe = self.open.pose.iter().fold(recipe, Recipe::posed);
        let recipe = if job.source.transparency { recipe.straight_through(true) } else { recipe };
        let recipe = if self.is_parted() { recipe.parts(job.parts) } else { recipe };
        recipe
            .read_from(&job.source)
            .max_edge(job.max_edge)
            .min_edge(job.min_edge)
            .clusters(compression.map(|options| options.clusters))
            .components(compression.map(|options| options.components))
            .weights(compression.map(|options| 8 * options.weights.bytes()))
    }
}
