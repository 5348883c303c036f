//! `lobe bake`: the transfer of a scene at its vertices, its texels, or points in space.

use std::sync::Arc;

use anyhow::{anyhow, bail};
use lobe::io::Shard;
use lobe::prt::{
    AdaptiveOptions, AdaptiveReport, BakeReport, BakeWork, BakedGlb, CompressReport, CompressedTransfer, Recipe,
    write_compressed_transfer,
};
use lobe::scene::{GltfDocument, Mesh, Scene, ScenePose};

use crate::args::open_scene::{OpenScene, ReadScene};
use crate::args::output::{self, has_extension};
use crate::args::sharing;
use crate::bake::backs::baked_backs;
use crate::bake::options::{Bake, ModeName};
use crate::bake::report;
use crate::bake::texels::Lightmap;
use crate::run::bake_watch::{Checkpoint, stop_before_writing, stopped, tell_if_too_late, watched, write_watched};
use crate::run::talk::Talk;

/// How a scene was split, and what came of it.
type SplitBy = (AdaptiveOptions, AdaptiveReport);

/// A scene, and how it was split, if it was.
type Split = (Arc<Scene>, Option<SplitBy>);

impl Bake {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.check_options()?;
        let inputs: Vec<_> = self.sharing.inputs().chain([self.input.path()]).collect();
        output::prepare_file(&self.output, &inputs)?;
        let checkpoint = self.sharing.checkpoint(&self.output);
        // The file of a shard that is done stands alone.
        if !self.fresh && self.sharing.shard.is_none() {
            checkpoint.check_kind(self.is_split())?;
        }
        // A .glb keeps what a glTF file holds beside the scene.
        let is_kept = self.is_glb();
        let ReadScene { scene, document, pose } = OpenScene::read(&self.input, &self.memory, is_kept, talk)?;
        self.tell_of_normal_maps(&scene, talk);
        let scene = self.splitting.split_long(scene)?;
        let (scene, document, lightmap) = self.unwrapped(scene, document, talk)?;
        if self.fresh {
            checkpoint.discard()?;
        }
        if self.is_split() {
            self.check_glb(&scene, document.as_ref())?;
        }
        let (scene, split) = self.split_adaptively(Arc::new(scene), &checkpoint, talk)?;
        if let Some(shard) = self.sharing.shard {
            return self.bake_shard(&scene, shard, &checkpoint, talk);
        }
        self.sharing.merge(&checkpoint, talk)?;
        let baked = self.bake_all(&scene, (document, pose, lightmap, split), &checkpoint, talk);
        let (report, compression) = self.sharing.merged(&checkpoint, baked)?;
        checkpoint.finish();
        tell_if_too_late(&self.output, talk);
        if (self.is_split() || self.splitting.is_asked()) && !self.is_glb() {
            let vertices = scene.vertex_count();
            let text = format!("transfer of {vertices} vertices after splitting; only a .glb holds the split mesh");
            talk.note(&self.output.display().to_string(), &text);
        }
        report::Done {
            scene: &scene,
            options: &self.bake_options(&scene),
            report: &report,
            compression: compression.as_ref(),
        }
        .tell(&self.output, self.json, talk)
    }

    /// The scene with texture coordinates of a lightmap, if one is asked for; its document is then in that.
    fn unwrapped(
        &self,
        scene: Scene,
        document: Option<GltfDocument>,
        talk: Talk,
    ) -> anyhow::Result<(Scene, Option<GltfDocument>, Lightmap)> {
        let Some(width) = self.texels else { return Ok((scene, document, Lightmap::default())) };
        let about = (&*self.input.name(), &self.memory, talk);
        let (scene, lightmap) = self.lightmap.unwrapped((scene, document), (width, self.is_glb()), about)?;
        Ok((scene, None, lightmap))
    }

    /// Says that transfer at vertices leaves the normal maps of their surfaces out, if there are any. The view that glossy surfaces
    /// mirror is tilted by them where it is looked up.
    fn tell_of_normal_maps(&self, scene: &Scene, talk: Talk) {
        let is_at_vertices = self.texels.is_none() && self.grid.is_none();
        if is_at_vertices && self.mode != ModeName::Glossy && scene.has_normal_maps() {
            let text =
                "has normal maps, which transfer at vertices does not hold; --texels W bakes at texels, where it does";
            talk.note(&self.input.name(), text);
        }
    }

    /// Bakes a shard, which is the file that it is kept in.
    fn bake_shard(&self, scene: &Arc<Scene>, shard: Shard, checkpoint: &Checkpoint, talk: Talk) -> anyhow::Result<()> {
        let work = self.work(scene)?;
        let report = checkpoint.watched(talk, |job| work.bake_shard(shard, job))?;
        checkpoint.finish_rounds();
        tell_if_too_late(&self.output, talk);
        let BakeReport { receivers: points, seconds, .. } = report;
        let points_in_all = work.points();
        sharing::Done { shard: shard.to_string(), points, points_in_all, seconds }.tell(&self.output, self.json, talk)
    }

    /// The scene with further vertices where transfer is off, unless the options say otherwise. Refuses work whose
    /// results could not be stored before it begins.
    fn split_adaptively(&self, scene: Arc<Scene>, checkpoint: &Checkpoint, talk: Talk) -> anyhow::Result<Split> {
        if !self.is_split() {
            return Ok((scene, None));
        }
        let options = self.bake_options(&scene);
        let work = BakeWork::at_vertices(Arc::clone(&scene), options)?;
        if self.is_glb() {
            BakedGlb::of_scene(&scene).check_size(self.order, work.channels())?;
        }
        checkpoint.check_room(&self.output, work.file_bytes(), work.bytes(), 0)?;
        let (split, report) = self.splitting.split_adaptively(&work, checkpoint, talk)?;
        talk.note(&self.input.name(), &self.splitting.note_of(&split, &report));
        Ok((Arc::new(split), Some((self.splitting.options(&scene)?, report))))
    }

    /// Bakes what is asked for, and writes it.
    fn bake_all(
        &self,
        scene: &Arc<Scene>,
        (document, pose, lightmap, split): (Option<GltfDocument>, Option<ScenePose>, Lightmap, Option<SplitBy>),
        checkpoint: &Checkpoint,
        talk: Talk,
    ) -> anyhow::Result<(BakeReport, Option<CompressReport>)> {
        // Prepare the output but for the transfer, so that its faults show before the bake.
        if self.is_glb() {
            self.check_document(scene)?;
        }
        let is_at_vertices = self.texels.is_none();
        let glb = if self.is_glb() && is_at_vertices { Some(self.glb(scene, document)?) } else { None };
        let glb = if self.backs { glb.map(|glb| glb.with_backs(scene)) } else { glb };
        let work = self.work(scene)?;
        // Refuse an output that has no room, before the bake.
        let channels = work.channels();
        if let Some(glb) = &glb {
            glb.check_size(self.order, channels)?;
        }
        if let Some(glb) = &lightmap.glb {
            glb.check_size(self.order, channels)?;
        }
        let size = glb.as_ref().map_or_else(|| work.file_bytes(), |glb| glb.size(self.order, channels));
        checkpoint.check_room(&self.output, size, work.bytes(), 0)?;
        // Bake, into the checkpoint.
        let (baked, report) = checkpoint.watched(talk, |job| work.bake(job))?;
        let recipe = self.recipe(&work, &report, (pose.as_ref(), split)).unwrap(lightmap.options.clone());
        if let (Some(glb), Some(transfer), true) = (&glb, baked.as_transfer(), self.backs) {
            let backs = baked_backs(scene, work.options(), channels, (checkpoint, self.fresh), talk)?;
            if let Some((backs, kept)) = backs {
                write_watched(talk, |job| glb.write_with_backs(&self.output, [transfer, &backs], &recipe, job))?;
                kept.finish();
                return Ok((report, None));
            }
            talk.note(&self.input.name(), "has no double-sided surfaces, so that --backs adds nothing");
        }
        // Write the results as they are, unless they are to be compressed.
        let Some(compression) = self.compression.options() else {
            write_watched(talk, |job| match (&glb, baked.as_transfer()) {
                (Some(glb), Some(transfer)) => glb.write(&self.output, transfer, &recipe, job),
                _ if let Some(glb) = &lightmap.glb => work.write_into_glb(&self.output, (glb, &baked), &recipe, job),
                _ => work.write(&self.output, &baked, &recipe, job),
            })?;
            return Ok((report, None));
        };
        // Compress them, and write the result.
        let Some(loaded) = baked.into_transfer()? else {
            bail!("--clusters, --components and --weights: of transfer vectors only")
        };
        let compressed = watched(talk, "compress", |job| CompressedTransfer::new(&loaded, &compression, job))?;
        let Ok((compressed, saved)) = compressed else { return stopped() };
        stop_before_writing()?;
        let recipe = recipe.relative_error(saved.relative_error);
        match glb {
            Some(glb) => glb.write_compressed(&self.output, &compressed, &recipe)?,
            None => write_compressed_transfer(&self.output, &compressed, &recipe)?,
        }
        Ok((report, Some(saved)))
    }

    /// The points that are asked for, and what is baked there.
    fn work(&self, scene: &Arc<Scene>) -> anyhow::Result<BakeWork> {
        let (scene, options) = (Arc::clone(scene), self.bake_options(scene));
        if let Some(counts) = self.grid {
            return BakeWork::in_grid(scene, counts, self.grid_box, options)
                .map_err(|error| anyhow!("--grid: {error}; --grid-box asks for another"));
        }
        if let Some(width) = self.texels {
            self.lightmap.check((&scene, width), &options, &self.memory, has_extension(&self.output, "exr"))?;
            return Ok(BakeWork::at_texels(scene, width, options)?.finished_by(self.lightmap.finish()));
        }
        Ok(BakeWork::at_vertices(scene, options)?)
    }

    /// Refuses meshes that are too many for a .glb, which has an accessor for each attribute of each of them.
    fn check_document(&self, scene: &Scene) -> anyhow::Result<()> {
        /// A million meshes of one triangle took 9.35 GB at order 1, with four accessors each.
        const BYTES_OF_ACCESSOR: u64 = 2340;
        let channels = self.bake_options(scene).channels_for(scene, scene.is_gray());
        // Positions, normals and triangles, what else a mesh has, and four numbers of transfer each.
        let transfer = (self.order.pow(2) * channels.count()).div_ceil(4);
        let accessors_of = |mesh: &Mesh| {
            let uvs = [0, 1].map(|set| mesh.uvs(set).is_empty());
            let is_missing = [mesh.tangents().is_empty(), uvs[0], uvs[1], mesh.colors().is_empty()];
            3 + is_missing.into_iter().filter(|is_missing| !is_missing).count() + transfer
        };
        let accessors: usize = scene.meshes().iter().map(accessors_of).sum();
        let meshes = scene.meshes().len();
        let bytes = BYTES_OF_ACCESSOR * accessors as u64;
        self.memory.check(&format!("a .glb of {meshes} meshes"), bytes, "fewer instances, or -o FILE.safetensors")
    }

    /// Refuses a .glb that cannot be, before the scene is split.
    fn check_glb(&self, scene: &Scene, document: Option<&GltfDocument>) -> anyhow::Result<()> {
        if self.is_glb() {
            self.check_document(scene)?;
            self.glb(scene, document.cloned())?;
        }
        Ok(())
    }

    fn glb(&self, scene: &Scene, document: Option<GltfDocument>) -> anyhow::Result<BakedGlb> {
        match document {
            Some(document) => {
                BakedGlb::of_document(document, scene).map_err(|error| anyhow!("{}: {error}", self.input.name()))
            }
            None => Ok(BakedGlb::of_scene(scene)),
        }
    }

    /// The recipe: everything that decides the bytes of the output, and nothing that differs from run to run.
    fn recipe(
        &self,
        work: &BakeWork,
        report: &BakeReport,
        (pose, split): (Option<&ScenePose>, Option<SplitBy>),
    ) -> Recipe {
        let compression = self.compression.options();
        let recipe = work.recipe(report);
        let recipe = split.iter().fold(recipe, |recipe, (options, report)| recipe.split_by(options, report));
        let recipe = pose.into_iter().fold(recipe, Recipe::posed);
        let recipe = if self.input.is_see_through() { recipe.straight_through(true) } else { recipe };
        recipe
            .scene(self.input.file_name())
            .max_edge(self.splitting.max_edge)
            .min_edge(self.splitting.min_edge)
            .clusters(compression.map(|options| options.clusters))
            .components(compression.map(|options| options.components))
            .weights(compression.map(|options| 8 * options.weights.bytes()))
    }
}
