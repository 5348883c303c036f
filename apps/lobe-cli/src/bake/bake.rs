//! `lobe bake`: the transfer of a scene at its vertices, its texels, or points in space.

use anyhow::anyhow;
use lobe::io::{Job, Shard};
use lobe::prt::{
    BakeReport, BakedGlb, Channels, CompressReport, CompressedTransfer, NeighborhoodGrid, Receivers, Recipe,
    TexelReceivers, bake_matrices_on_disk, bake_matrices_shard, bake_neighborhood_on_disk, bake_neighborhood_shard,
    bake_on_disk, bake_shard, write_compressed_transfer, write_lightmap, write_matrices, write_neighborhood,
    write_transfer,
};
use lobe::scene::{Bvh, GltfDocument, Scene};

use crate::args::output::{self, has_extension};
use crate::args::sharing;
use crate::bake::options::{Bake, ModeName};
use crate::bake::report;
use crate::bake::split;
use crate::run::bake_watch::{Checkpoint, stop_before_writing, stopped, tell_if_too_late, watched, write_watched};
use crate::run::talk::Talk;

impl Bake {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.check_options()?;
        let inputs: Vec<_> = self.sharing.inputs().chain([self.input.path()]).collect();
        output::prepare_file(&self.output, &inputs)?;
        let checkpoint = self.sharing.checkpoint(&self.output);
        if !self.fresh {
            checkpoint.check_kind(self.splitting.is_adaptive())?;
        }
        // A .glb keeps what a glTF file holds beside the scene, unless the scene is changed.
        let is_kept = self.is_glb() && !self.splitting.is_asked();
        let (scene, document) = if is_kept {
            self.input.read_with_document(&self.memory, talk)?
        } else {
            (self.input.read(&self.memory, talk)?, None)
        };
        let scene = self.splitting.split_long(scene)?;
        if self.fresh {
            checkpoint.discard()?;
        }
        if let Some(shard) = self.sharing.shard {
            return self.bake_shard(&scene, shard, &checkpoint, talk);
        }
        let scene = self.split_adaptively(scene, &checkpoint, talk)?;
        self.sharing.merge(&checkpoint, talk)?;
        let baked = self.bake_all(&scene, document, &checkpoint, talk);
        let (report, compression) = self.sharing.merged(&checkpoint, baked)?;
        checkpoint.finish();
        tell_if_too_late(&self.output, talk);
        report::Done {
            scene: &scene,
            options: &self.bake_options(),
            report: &report,
            compression: compression.as_ref(),
        }
        .tell(&self.output, self.json, talk)
    }

    /// Bakes what is asked for, and writes it.
    fn bake_all(
        &self,
        scene: &Scene,
        document: Option<GltfDocument>,
        checkpoint: &Checkpoint,
        talk: Talk,
    ) -> anyhow::Result<(BakeReport, Option<CompressReport>)> {
        if let Some(counts) = self.grid {
            Ok((self.bake_grid(scene, counts, checkpoint, talk)?, None))
        } else if let Some(width) = self.texels {
            Ok((self.bake_texels(scene, width, checkpoint, talk)?, None))
        } else if self.mode == ModeName::Glossy {
            Ok((self.bake_glossy(scene, checkpoint, talk)?, None))
        } else {
            self.bake_vertices(scene, document, checkpoint, talk)
        }
    }

    /// Bakes a shard, which is the file that it is kept in.
    fn bake_shard(&self, scene: &Scene, shard: Shard, checkpoint: &Checkpoint, talk: Talk) -> anyhow::Result<()> {
        let (options, bvh) = (self.bake_options(), Bvh::new(scene));
        let (points_in_all, report) = if let Some(counts) = self.grid {
            let grid = self.points_of_grid(scene, counts)?;
            let bake = |job: Job<'_>| bake_neighborhood_shard(scene, &bvh, &grid, &options, shard, job);
            (counts.iter().product(), checkpoint.watched(talk, bake)?)
        } else if let Some(width) = self.texels {
            let texels = TexelReceivers::new(scene, width)?;
            let bake = |job: Job<'_>| bake_shard(scene, &bvh, texels.receivers(), &options, shard, job);
            (texels.receivers().len(), checkpoint.watched(talk, bake)?)
        } else {
            let receivers = Receivers::at_vertices(scene)?;
            let report = checkpoint.watched(talk, |job| match self.mode {
                ModeName::Glossy => bake_matrices_shard(scene, &bvh, &receivers, &options, shard, job),
                _ => bake_shard(scene, &bvh, &receivers, &options, shard, job),
            })?;
            (receivers.len(), report)
        };
        tell_if_too_late(&self.output, talk);
        let BakeReport { receivers: points, seconds, .. } = report;
        sharing::Done { shard: shard.to_string(), points, points_in_all, seconds }.tell(&self.output, self.json, talk)
    }

    /// The scene with further vertices where transfer changes, if the options say so. Refuses work whose results could
    /// not be stored before it begins.
    fn split_adaptively(&self, scene: Scene, checkpoint: &Checkpoint, talk: Talk) -> anyhow::Result<Scene> {
        let options = self.bake_options();
        if self.splitting.is_adaptive() {
            let channels = options.channels_for(&scene, Receivers::at_vertices(&scene)?.is_gray());
            if self.is_glb() {
                BakedGlb::of_scene(&scene).check_size(self.order, channels)?;
            }
            let rows = |power| bytes(scene.vertex_count(), self.order.pow(power), channels);
            let transfer = rows(if self.mode == ModeName::Glossy { 4 } else { 2 });
            checkpoint.check_room(&self.output, transfer, transfer, rows(2))?;
        }
        let (scene, report) = self.splitting.split_adaptively(scene, &options, checkpoint, talk)?;
        if let (Some(report), Some(threshold)) = (report, self.splitting.adaptive) {
            talk.note(&self.input.name(), &split::note_of(&report, threshold));
        }
        Ok(scene)
    }

    fn bake_vertices(
        &self,
        scene: &Scene,
        document: Option<GltfDocument>,
        checkpoint: &Checkpoint,
        talk: Talk,
    ) -> anyhow::Result<(BakeReport, Option<CompressReport>)> {
        // Prepare the output but for the transfer, so that its faults show before the bake.
        let glb = if self.is_glb() { Some(self.glb(scene, document, talk)?) } else { None };
        let (receivers, options) = (Receivers::at_vertices(scene)?, self.bake_options());
        // Refuse an output that has no room, before the bake.
        let channels = options.channels_for(scene, receivers.is_gray());
        let transfer = bytes(receivers.len(), self.order.pow(2), channels);
        if let Some(glb) = &glb {
            glb.check_size(self.order, channels)?;
        }
        checkpoint.check_room(
            &self.output,
            glb.as_ref().map_or(transfer, |glb| glb.size(self.order, channels)),
            transfer,
            0,
        )?;
        let bvh = Bvh::new(scene);
        // Bake, into the checkpoint.
        let (transfer, report) =
            checkpoint.watched(talk, |job| bake_on_disk(scene, &bvh, &receivers, &options, job))?;
        let recipe = self.recipe(scene, &report);
        // Write the transfer as it is, unless it is to be compressed.
        let Some(compression) = self.compression.options() else {
            write_watched(talk, |job| match glb {
                Some(glb) => glb.write(&self.output, &transfer, &recipe, job),
                None => write_transfer(&self.output, &transfer, &recipe, job),
            })?;
            return Ok((report, None));
        };
        // Compress it, and write the result.
        let loaded = transfer.load()?;
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

    fn bake_glossy(&self, scene: &Scene, checkpoint: &Checkpoint, talk: Talk) -> anyhow::Result<BakeReport> {
        let (receivers, options) = (Receivers::at_vertices(scene)?, self.bake_options());
        let bytes = bytes(receivers.len(), self.order.pow(4), options.channels_for(scene, receivers.is_gray()));
        checkpoint.check_room(&self.output, bytes, bytes, 0)?;
        let bvh = Bvh::new(scene);
        let (matrices, report) =
            checkpoint.watched(talk, |job| bake_matrices_on_disk(scene, &bvh, &receivers, &options, job))?;
        let recipe = self.recipe(scene, &report);
        write_watched(talk, |job| write_matrices(&self.output, &matrices, &recipe, job))?;
        Ok(report)
    }

    fn bake_texels(
        &self,
        scene: &Scene,
        width: usize,
        checkpoint: &Checkpoint,
        talk: Talk,
    ) -> anyhow::Result<BakeReport> {
        self.check_memory(scene, width)?;
        let texels = TexelReceivers::new(scene, width)?;
        let options = self.bake_options();
        let channels = options.channels_for(scene, texels.receivers().is_gray());
        let [picture, receivers] =
            [width * width, texels.receivers().len()].map(|points| bytes(points, self.order.pow(2), channels));
        checkpoint.check_room(&self.output, picture, receivers, 0)?;
        let bvh = Bvh::new(scene);
        let (transfer, report) =
            checkpoint.watched(talk, |job| bake_on_disk(scene, &bvh, texels.receivers(), &options, job))?;
        let (picture, recipe) = (texels.rows(&transfer)?, self.recipe(scene, &report));
        write_watched(talk, |job| match has_extension(&self.output, "exr") {
            true => write_lightmap(&self.output, &picture, &recipe, job),
            false => write_transfer(&self.output, &picture, &recipe, job),
        })?;
        Ok(report)
    }

    /// Refuses a lightmap that takes too much memory: of an .exr picture all numbers, and the file while it grows.
    fn check_memory(&self, scene: &Scene, width: usize) -> anyhow::Result<()> {
        let channels = self.bake_options().channels_for(scene, scene.is_gray());
        let is_picture = has_extension(&self.output, "exr");
        let numbers = if is_picture { 2 * bytes(width * width, self.order.pow(2), channels) } else { 0 };
        let what = format!("--texels {width}");
        self.memory.check(&what, numbers + TexelReceivers::bytes_for(width), "fewer --texels, or a lower --order")
    }

    fn bake_grid(
        &self,
        scene: &Scene,
        counts: [usize; 3],
        checkpoint: &Checkpoint,
        talk: Talk,
    ) -> anyhow::Result<BakeReport> {
        let grid = self.points_of_grid(scene, counts)?;
        let options = self.bake_options();
        let bytes = bytes(counts.iter().product(), self.order.pow(4), options.channels_for(scene, true));
        checkpoint.check_room(&self.output, bytes, bytes, 0)?;
        let bvh = Bvh::new(scene);
        let (matrices, report) =
            checkpoint.watched(talk, |job| bake_neighborhood_on_disk(scene, &bvh, &grid, &options, job))?;
        let recipe = self.recipe(scene, &report);
        write_watched(talk, |job| write_neighborhood(&self.output, &grid, &matrices, &recipe, job))?;
        Ok(report)
    }

    /// Points in the box asked for, or within that of the scene: not at its sides, where floors and walls are.
    fn points_of_grid(&self, scene: &Scene, counts: [usize; 3]) -> anyhow::Result<NeighborhoodGrid> {
        let [min, max] = match self.grid_box {
            Some(numbers) => {
                let [a, b] = [0, 3].map(|first| [0, 1, 2].map(|k| numbers[first + k]));
                [[0, 1, 2].map(|k| a[k].min(b[k])), [0, 1, 2].map(|k| a[k].max(b[k]))]
            }
            None => {
                let [min, max] = scene.world_bounds();
                let half = |k: usize| (max[k] - min[k]) / (2 * counts[k]) as f64;
                [[0, 1, 2].map(|k| min[k] + half(k)), [0, 1, 2].map(|k| max[k] - half(k))]
            }
        };
        NeighborhoodGrid::between(min, max, counts)
            .map_err(|error| anyhow!("--grid: {error}; --grid-box asks for another"))
    }

    fn glb(&self, scene: &Scene, document: Option<GltfDocument>, talk: Talk) -> anyhow::Result<BakedGlb> {
        if let Some(document) = document {
            return BakedGlb::of_document(document, scene).map_err(|error| anyhow!("{}: {error}", self.input.name()));
        }
        if self.input.is_gltf() {
            let text = "split, so what the file holds beside its triangles, base colors and their textures is left out";
            talk.note(&self.input.name(), text);
        }
        Ok(BakedGlb::of_scene(scene))
    }

    /// The recipe: everything that decides the bytes of the output, and nothing that differs from run to run.
    fn recipe(&self, scene: &Scene, report: &BakeReport) -> Recipe {
        let compression = self.compression.options();
        let recipe = Recipe::of_bake(scene, &self.bake_options(), report);
        let recipe = if self.input.is_see_through() { recipe.straight_through(true) } else { recipe };
        recipe
            .scene(self.input.file_name())
            .max_edge(self.splitting.max_edge)
            .adaptive(self.splitting.adaptive)
            .min_edge(self.splitting.min_edge)
            .max_vertices(self.splitting.max_vertices)
            .texels(self.texels)
            .grid(self.grid)
            .grid_box(self.grid_box)
            .clusters(compression.map(|options| options.clusters))
            .components(compression.map(|options| options.components))
            .weights(compression.map(|options| 8 * options.weights.bytes()))
    }
}

/// The bytes of `points` with `numbers` for each channel.
fn bytes(points: usize, numbers: usize, channels: Channels) -> u64 {
    (points as u64).saturating_mul((4 * numbers * channels.count()) as u64)
}
