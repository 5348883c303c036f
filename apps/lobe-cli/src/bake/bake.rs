//! `lobe bake`: the transfer of a scene at its vertices, its texels, or points in space.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use clap::{Args, ValueEnum};
use lobe::io::Fingerprint;
use lobe::prt::{
    BakeOptions, BakeReport, BakedGlb, Channels, CompressReport, CompressedTransfer, Grid, Mode, Receivers, Recipe,
    RecipeMode, TexelReceivers, Transfer, bake_matrices_on_disk, bake_neighborhood_on_disk, bake_on_disk,
    fingerprint_scene, write_compressed_transfer, write_lightmap, write_matrices, write_neighborhood, write_transfer,
};
use lobe::scene::{Bounds, Bvh, GltfDocument, Scene};

use crate::args::compression::Compression;
use crate::args::memory::MemoryLimit;
use crate::args::output;
use crate::args::scene_input::SceneInput;
use crate::args::values;
use crate::bake::report;
use crate::bake::split;
use crate::bake::split::Splitting;
use crate::run::bake_watch::{Checkpoint, tell_if_too_late, watched};
use crate::run::bake_write::{stop_before_writing, stopped, write_watched};
use crate::run::talk::Talk;

/// The most paths that a bake takes.
const MAX_SAMPLES: usize = 1 << 24;
const MAX_BOUNCES: usize = 255;

/// Bytes that a texel of a lightmap takes in memory at most, beside what is written: a place on a triangle, and a
/// receiver.
const TEXEL: u64 = 40 + 44;

const NOTES: &str = "\
Stopping: results are kept in OUT.checkpoint, those of --adaptive in OUT.checkpoint.split-0, -1 and so on. Ctrl-C ends the bake \
with exit code 2 and leaves these files, and so does whatever kills it, at a cost of at most 10 s of rays. The same command \
reads the scene, splits it where that is known already, and goes on from there, to the same bytes; at the end the files are \
removed. Compression begins anew.

Disk: 4 n² bytes for each vertex and channel, taken from the start, as many again for the output, and as many for --adaptive.

Memory: 20 MB and some 820 bytes for each vertex of the scene once split, at any order. Only --adaptive, compression and --texels as \
.exr take results into memory: twice 4 n² bytes for each vertex or texel and channel. --texels takes 84 bytes for each texel.";

#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Args)]
#[command(after_help = NOTES)]
pub(crate) struct Bake {
    #[command(flatten)]
    input: SceneInput,
    /// The scene with transfer at its vertices, a .glb file, or the transfer alone, a .safetensors file, as which --mode glossy,
    /// --texels and --grid are written; of --texels also an .exr picture with a layer for each coefficient
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// The light that is baked
    #[arg(long, value_enum, default_value = "interreflected")]
    mode: ModeName,
    /// The order (number of bands), 1 to 8: n² coefficients, three times as many where light meets colors
    #[arg(long, value_name = "N", default_value = "4", value_parser = order)]
    order: usize,
    /// Paths from each vertex, 1 to 16777216; powers of two are distributed best
    #[arg(long, value_name = "N", default_value = "1024", value_parser = samples)]
    samples: u32,
    /// With --mode interreflected and glossy: reflections at most, 0 to 255 [default: 3]
    #[arg(long, value_name = "B", value_parser = bounces)]
    bounces: Option<usize>,
    /// With --mode interreflected and glossy: leave out reflections that carry less than this part of the energy; 0 keeps all [default: 0.001]
    #[arg(long, value_name = "X", value_parser = part)]
    energy_stop: Option<f64>,
    /// The same seed gives the same bytes
    #[arg(long, value_name = "S", default_value = "0")]
    seed: u64,
    #[command(flatten)]
    splitting: Splitting,
    /// Bake at the W × W texels of a lightmap instead of at vertices; scenes need texture coordinates that
    /// do not overlap, in set 1 or else 0
    #[arg(long, value_name = "W", value_parser = texels, conflicts_with_all = ["grid", "clusters", "components", "weights"])]
    texels: Option<usize>,
    /// Bake the light that arrives at points in space, as matrices: NX × NY × NZ points in the scene's box
    #[arg(long, value_name = "NX,NY,NZ", value_parser = grid, conflicts_with_all = ["clusters", "components", "weights"])]
    grid: Option<[usize; 3]>,
    /// With --grid: two corners of the box, whose corners are points [default: the scene's box, with points in the middle of
    /// as many equal parts]
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1", value_parser = values::numbers::<6>, requires = "grid", allow_hyphen_values = true)]
    grid_box: Option<[f64; 6]>,
    #[command(flatten)]
    compression: Compression,
    #[command(flatten)]
    memory: MemoryLimit,
    /// Start anew, even if there is a checkpoint of a bake that was stopped
    #[arg(long)]
    fresh: bool,
    /// Print {"vertices", "triangles", "rays", "seconds", "stderr_dc", ...} on stdout
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum ModeName {
    /// Light that meets nothing on its way
    Unshadowed,
    /// Light that the scene may block
    Shadowed,
    /// Light that the scene may block, and that its surfaces reflect
    Interreflected,
    /// The same light before a vertex reflects it, as matrices: for glossy surfaces
    Glossy,
}

impl ModeName {
    const fn mode(self) -> Mode {
        match self {
            Self::Unshadowed => Mode::Unshadowed,
            Self::Shadowed => Mode::Shadowed,
            Self::Interreflected | Self::Glossy => Mode::Interreflected,
        }
    }

    const fn in_recipe(self) -> RecipeMode {
        match self {
            Self::Unshadowed => RecipeMode::Unshadowed,
            Self::Shadowed => RecipeMode::Shadowed,
            Self::Interreflected => RecipeMode::Interreflected,
            Self::Glossy => RecipeMode::Glossy,
        }
    }
}

fn order(text: &str) -> Result<usize, String> {
    values::whole(text, 1, Transfer::MAX_ORDER, "an order (number of bands)")
}

fn samples(text: &str) -> Result<u32, String> {
    values::whole(text, 1, MAX_SAMPLES, "a number of paths").map(|n| n as u32)
}

fn bounces(text: &str) -> Result<usize, String> {
    values::whole(text, 0, MAX_BOUNCES, "a number of reflections")
}

fn texels(text: &str) -> Result<usize, String> {
    values::whole(text, 1, 1 << 14, "a number of texels")
}

/// Points along three axes.
fn grid(text: &str) -> Result<[usize; 3], String> {
    let numbers = values::numbers::<3>(text)?;
    if numbers.iter().any(|n| n.fract() != 0.0 || !(2.0..=4096.0).contains(n)) {
        return Err("expected three whole numbers from 2 to 4096".to_owned());
    }
    Ok(numbers.map(|n| n as usize))
}

fn part(text: &str) -> Result<f64, String> {
    match values::finite(text)? {
        x if (0.0..1.0).contains(&x) => Ok(x),
        x => Err(format!("expected a number from 0 to below 1, found {x}")),
    }
}

impl Bake {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.check_options()?;
        output::check_not_input(&self.output, self.input.path())?;
        output::prepare_file(&self.output)?;
        let checkpoint = Checkpoint::beside(&self.output);
        if !self.fresh {
            checkpoint.check_kind(self.splitting.is_adaptive())?;
        }
        // A .glb keeps what a glTF file holds beside the scene, unless the scene is changed.
        let is_kept = self.is_glb() && !self.splitting.is_asked();
        let (scene, document) =
            if is_kept { self.input.read_with_document(talk)? } else { (self.input.read(talk)?, None) };
        let scene = self.splitting.split_long(scene)?;
        if self.fresh {
            checkpoint.discard()?;
        }
        let scene = self.split_adaptively(scene, &checkpoint, talk)?;
        let world = World::of(&scene);
        let (report, compression) = if let Some(counts) = self.grid {
            (self.bake_grid(&world, counts, &checkpoint, talk)?, None)
        } else if let Some(width) = self.texels {
            (self.bake_texels(&world, width, &checkpoint, talk)?, None)
        } else if self.mode == ModeName::Glossy {
            (self.bake_glossy(&world, &checkpoint, talk)?, None)
        } else {
            self.bake_vertices(&world, document, &checkpoint, talk)?
        };
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

    /// Refuses options that would be ignored.
    fn check_options(&self) -> anyhow::Result<()> {
        let is_glossy = self.mode == ModeName::Glossy;
        let has_bounces = is_glossy || self.mode == ModeName::Interreflected;
        let (has_edges, is_compressed) = (self.splitting.is_asked(), self.compression.options().is_some());
        let is_elsewhere = self.texels.is_some() || self.grid.is_some();
        let ignored = [
            (self.bounces.is_some() && !has_bounces, "--bounces: only of --mode interreflected and glossy"),
            (self.energy_stop.is_some() && !has_bounces, "--energy-stop: only of --mode interreflected and glossy"),
            (has_edges && is_elsewhere, "--max-edge and --adaptive: light is not at vertices with --texels and --grid"),
            (is_glossy && is_elsewhere, "--mode glossy: at vertices only; --grid bakes matrices by itself"),
            (is_glossy && is_compressed, "--clusters, --components and --weights: not of --mode glossy"),
            (
                self.is_glb() && (is_glossy || is_elsewhere),
                "-o: --mode glossy, --texels and --grid are written as .safetensors",
            ),
            (self.splitting.min_edge.is_some() && !self.splitting.is_adaptive(), "--min-edge: only of --adaptive"),
        ];
        if let Some((_, message)) = ignored.into_iter().find(|(is_ignored, _)| *is_ignored) {
            bail!(message);
        }
        let is_picture = has_extension(&self.output, "exr");
        if self.texels.is_some() && !is_picture && !has_extension(&self.output, "safetensors") {
            bail!("{}: expected a name that ends in .safetensors or .exr", self.output.display());
        }
        if self.texels.is_none() && !self.is_glb() && !has_extension(&self.output, "safetensors") {
            bail!("{}: expected a name that ends in .glb or .safetensors", self.output.display());
        }
        Ok(())
    }

    fn is_glb(&self) -> bool {
        has_extension(&self.output, "glb")
    }

    fn bake_options(&self) -> BakeOptions {
        let defaults = BakeOptions::default();
        defaults
            .clone()
            .mode(self.mode.mode())
            .order(self.order)
            .samples(self.samples)
            .bounces(self.bounces.unwrap_or(defaults.bounces))
            .energy_stop(self.energy_stop.unwrap_or(defaults.energy_stop))
            .seed(self.seed)
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
            checkpoint.check_room_to_split(&self.output, transfer, transfer, rows(2))?;
        }
        let (scene, report) = self.splitting.split_adaptively(scene, &options, checkpoint, talk)?;
        if let Some(report) = report {
            talk.note(&self.input.name(), &split::note_of(&report));
        }
        Ok(scene)
    }

    fn bake_vertices(
        &self,
        world: &World<'_>,
        document: Option<GltfDocument>,
        checkpoint: &Checkpoint,
        talk: Talk,
    ) -> anyhow::Result<(BakeReport, Option<CompressReport>)> {
        // Prepare the output but for the transfer, so that its faults show before the bake.
        let glb = if self.is_glb() { Some(self.glb(world.scene, document, talk)?) } else { None };
        let (receivers, options) = (Receivers::at_vertices(&world.near)?, self.bake_options());
        // Refuse an output that has no room, before the bake.
        let channels = options.channels_for(&world.near, receivers.is_gray());
        let transfer = bytes(receivers.len(), self.order.pow(2), channels);
        if let Some(glb) = &glb {
            glb.check_size(self.order, channels)?;
        }
        checkpoint.check_room(
            &self.output,
            glb.as_ref().map_or(transfer, |glb| glb.size(self.order, channels)),
            transfer,
        )?;
        let bvh = Bvh::new(&world.near);
        // Bake, into the checkpoint.
        let (transfer, report) =
            checkpoint.watched(talk, |job| bake_on_disk(&world.near, &bvh, &receivers, &options, job))?;
        let recipe = self.recipe(world.scene, &report);
        // Write the transfer as it is, unless it is to be compressed.
        let Some(compression) = self.compression.options() else {
            write_watched(&transfer, talk, |transfer| match glb {
                Some(glb) => glb.write(&self.output, transfer, &recipe),
                None => write_transfer(&self.output, transfer, &recipe),
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

    fn bake_glossy(&self, world: &World<'_>, checkpoint: &Checkpoint, talk: Talk) -> anyhow::Result<BakeReport> {
        let (receivers, options) = (Receivers::at_vertices(&world.near)?, self.bake_options());
        let bytes = bytes(receivers.len(), self.order.pow(4), options.channels_for(&world.near, receivers.is_gray()));
        checkpoint.check_room(&self.output, bytes, bytes)?;
        let bvh = Bvh::new(&world.near);
        let (matrices, report) =
            checkpoint.watched(talk, |job| bake_matrices_on_disk(&world.near, &bvh, &receivers, &options, job))?;
        let recipe = self.recipe(world.scene, &report);
        write_watched(&matrices, talk, |matrices| write_matrices(&self.output, matrices, &recipe))?;
        Ok(report)
    }

    fn bake_texels(
        &self,
        world: &World<'_>,
        width: usize,
        checkpoint: &Checkpoint,
        talk: Talk,
    ) -> anyhow::Result<BakeReport> {
        self.check_memory(&world.near, width)?;
        let texels = TexelReceivers::new(&world.near, width)?;
        let options = self.bake_options();
        let channels = options.channels_for(&world.near, texels.receivers().is_gray());
        let [picture, receivers] =
            [width * width, texels.receivers().len()].map(|points| bytes(points, self.order.pow(2), channels));
        checkpoint.check_room(&self.output, picture, receivers)?;
        let bvh = Bvh::new(&world.near);
        let (transfer, report) =
            checkpoint.watched(talk, |job| bake_on_disk(&world.near, &bvh, texels.receivers(), &options, job))?;
        let (picture, recipe) = (texels.rows(&transfer)?, self.recipe(world.scene, &report));
        write_watched(&picture, talk, |rows| match has_extension(&self.output, "exr") {
            true => write_lightmap(&self.output, rows, &recipe),
            false => write_transfer(&self.output, rows, &recipe),
        })?;
        Ok(report)
    }

    /// Refuses a lightmap that takes too much memory: of an .exr picture all numbers, and the file while it grows.
    fn check_memory(&self, scene: &Scene, width: usize) -> anyhow::Result<()> {
        let channels = self.bake_options().channels_for(scene, scene.is_gray());
        let is_picture = has_extension(&self.output, "exr");
        let numbers = if is_picture { 2 * bytes(width * width, self.order.pow(2), channels) } else { 0 };
        let what = format!("--texels {width}");
        self.memory.check(&what, numbers + TEXEL * (width * width) as u64, "fewer --texels, or a lower --order")
    }

    fn bake_grid(
        &self,
        world: &World<'_>,
        counts: [usize; 3],
        checkpoint: &Checkpoint,
        talk: Talk,
    ) -> anyhow::Result<BakeReport> {
        let grid = self.points_of_grid(world.scene, counts)?;
        let near = world.grid(&grid)?;
        let options = self.bake_options();
        let bytes = bytes(counts.iter().product(), self.order.pow(4), options.channels_for(&world.near, true));
        checkpoint.check_room(&self.output, bytes, bytes)?;
        let bvh = Bvh::new(&world.near);
        let (matrices, report) =
            checkpoint.watched(talk, |job| bake_neighborhood_on_disk(&world.near, &bvh, &near, &options, job))?;
        let recipe = self.recipe(world.scene, &report);
        write_watched(&matrices, talk, |matrices| write_neighborhood(&self.output, &grid, matrices, &recipe))?;
        Ok(report)
    }

    /// Points in the box asked for, or within that of the scene: not at its sides, where floors and walls are.
    fn points_of_grid(&self, scene: &Scene, counts: [usize; 3]) -> anyhow::Result<Grid> {
        let bounds = match self.grid_box {
            Some(numbers) => {
                let [a, b] = [0, 3].map(|first| [0, 1, 2].map(|k| numbers[first + k] as f32));
                Bounds { min: [0, 1, 2].map(|k| a[k].min(b[k])), max: [0, 1, 2].map(|k| a[k].max(b[k])) }
            }
            None => {
                let Bounds { min, max } = scene.bounds();
                let half = |k: usize| (max[k] - min[k]) / (2 * counts[k]) as f32;
                Bounds { min: [0, 1, 2].map(|k| min[k] + half(k)), max: [0, 1, 2].map(|k| max[k] - half(k)) }
            }
        };
        Grid::new(bounds, counts).map_err(|error| anyhow!("--grid: {error}; --grid-box asks for another"))
    }

    fn glb(&self, scene: &Scene, document: Option<GltfDocument>, talk: Talk) -> anyhow::Result<BakedGlb> {
        if let Some(document) = document {
            return Ok(BakedGlb::of_document(document, scene)?);
        }
        if self.input.is_gltf() {
            let text = "split, so what the file holds beside its triangles, base colors and their textures is left out";
            talk.note(&self.input.name(), text);
        }
        Ok(BakedGlb::of_scene(scene))
    }

    /// The recipe: everything that decides the bytes of the output, and nothing that differs from run to run.
    fn recipe(&self, scene: &Scene, report: &BakeReport) -> Recipe {
        let mut fingerprint = Fingerprint::of_kind(0);
        fingerprint_scene(&mut fingerprint, scene);
        let compression = self.compression.options();
        Recipe::of_bake(&self.bake_options(), report)
            .scene(self.input.file_name())
            .scene_hash(fingerprint.to_string())
            .mode(self.mode.in_recipe())
            .max_edge(self.splitting.max_edge)
            .adaptive(self.splitting.adaptive)
            .min_edge(self.splitting.min_edge)
            .texels(self.texels)
            .grid(self.grid)
            .grid_box(self.grid_box)
            .clusters(compression.map(|options| options.clusters))
            .components(compression.map(|options| options.components))
            .weights(compression.map(|options| 8 * options.weights.bytes()))
    }
}

/// A scene, and the same where rays are traced: near the origin.
struct World<'a> {
    scene: &'a Scene,
    near: Cow<'a, Scene>,
    shift: [f32; 3],
}

impl<'a> World<'a> {
    fn of(scene: &'a Scene) -> Self {
        let (near, shift) = scene.near_origin();
        Self { scene, near, shift }
    }

    /// The points of a grid of the scene among the triangles near the origin.
    fn grid(&self, grid: &Grid) -> anyhow::Result<Grid> {
        let moved = |corner: [f32; 3]| [0, 1, 2].map(|k| corner[k] - self.shift[k]);
        let Bounds { min, max } = grid.bounds();
        Ok(Grid::new(Bounds { min: moved(min), max: moved(max) }, grid.counts())?)
    }
}

/// The bytes of `points` with `numbers` for each channel.
fn bytes(points: usize, numbers: usize, channels: Channels) -> u64 {
    (points as u64).saturating_mul((4 * numbers * channels.count()) as u64)
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}
