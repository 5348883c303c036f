//! `lobe bake`: a scene whose vertices know what they do to light.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use clap::{Args, ValueEnum};
use lobe::prt::{
    AdaptiveOptions, BakeOptions, BakeReport, BakedGlb, Channels, CompressOptions, CompressReport, CompressedTransfer,
    Fingerprint, Grid, Mode, Receivers, TexelReceivers, Transfer, WeightBits, bake_matrices_resumable,
    bake_neighbourhood_resumable, bake_resumable, split_adaptively, write_compressed_transfer, write_lightmap,
    write_matrices, write_neighbourhood, write_transfer,
};
use lobe::scene::{Bounds, Bvh, Scene};
use serde::Serialize;
use serde_json::{Value, json};

use crate::bake_watch::{Checkpoint, show};
use crate::memory::MemoryLimit;
use crate::scene_input::SceneInput;
use crate::talk::Talk;
use crate::{compression, output, values};

/// As many as the bake takes.
const MAX_SAMPLES: usize = 1 << 24;
const MAX_BOUNCES: usize = 255;

/// Enough to see where transfer changes by a tenth.
const ADAPTIVE_SAMPLES: u32 = 256;

/// Rays that start higher above surfaces than this part of the scene's diagonal may pass through what is near: told.
const HIGH_START: f32 = 1e-4;

/// The shortest edge that is split without --min-edge, as a part of the scene's diagonal.
const SHORTEST_EDGE: f32 = 1.0 / 512.0;

/// Bytes that a texel of a lightmap takes in memory at most, beside what is written: a place on a triangle, and a receiver.
const TEXEL: u64 = 40 + 44;

const NOTES: &str = "\
Stopping: results are kept in OUT.checkpoint. Ctrl-C ends the bake with exit code 2 and leaves that file, and so does whatever \
kills it, at a cost of at most 10 s of rays. The same command reads and splits the scene once more and goes on from there, \
to the same bytes; at the end the file is removed.

Disk: 4 n² bytes for each vertex and channel, taken from the start, and as many again for the output.

Memory: 20 MB and some 820 bytes for each vertex of the scene once split, at any order. Only compression and --texels as .exr take \
results into memory: twice 4 n² bytes for each vertex or texel and channel. --texels takes 84 bytes for each texel.";

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
    /// What light may do on its way to a vertex
    #[arg(long, value_enum, default_value = "interreflected")]
    mode: ModeName,
    /// The order (number of bands), 1 to 8: n² coefficients, three times as many where light meets colours
    #[arg(long, value_name = "N", default_value = "4", value_parser = order)]
    order: usize,
    /// Paths from each vertex, 1 to 16777216; powers of two are distributed best
    #[arg(long, value_name = "N", default_value = "1024", value_parser = samples)]
    samples: u32,
    /// With --mode interreflected and glossy: reflections at most, 0 to 255 [default: 3]
    #[arg(long, value_name = "B", value_parser = bounces)]
    bounces: Option<usize>,
    /// With --mode interreflected and glossy: leave out bounces that carry less than this part of the energy; 0 keeps all [default: 0.001]
    #[arg(long, value_name = "X", value_parser = part)]
    energy_stop: Option<f64>,
    /// The same seed gives the same bytes
    #[arg(long, value_name = "S", default_value = "0")]
    seed: u64,
    /// Split triangles first until no edge is longer than this, in the scene's unit of length
    #[arg(long, value_name = "L", value_parser = values::positive)]
    max_edge: Option<f64>,
    /// Split edges whose ends' transfer differs by more than this part of the mean, such as 0.1
    #[arg(long, value_name = "X", value_parser = values::positive)]
    adaptive: Option<f64>,
    /// With --adaptive: leave edges that are shorter than this [default: 1/512 of the scene's diagonal]
    #[arg(long, value_name = "L", value_parser = values::positive)]
    min_edge: Option<f64>,
    /// Bake at the texels of a lightmap of so many by so many instead of at vertices; scenes need texture coordinates that
    /// do not overlap, in set 1 or else 0
    #[arg(long, value_name = "W", value_parser = texels, conflicts_with_all = ["grid", "clusters", "components", "weights"])]
    texels: Option<usize>,
    /// Bake what arrives at points in space, matrices, at so many along x, y and z of the scene's box
    #[arg(long, value_name = "NX,NY,NZ", value_parser = grid, conflicts_with_all = ["clusters", "components", "weights"])]
    grid: Option<[usize; 3]>,
    /// With --grid: two corners of the box, whose corners are points [default: the scene's box, with points in the middle of
    /// as many equal parts]
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1", value_parser = values::numbers::<6>, requires = "grid", allow_hyphen_values = true)]
    grid_box: Option<[f64; 6]>,
    /// Compress to this many clusters of vertices at most, 1 to 65536 [default with --components or --weights: 64]
    #[arg(long, value_name = "K", value_parser = compression::clusters)]
    clusters: Option<usize>,
    /// Compress to this many components in each cluster [default with --clusters or --weights: 8]
    #[arg(long, value_name = "N", value_parser = compression::components)]
    components: Option<usize>,
    /// Compress, with so many bits for a weight: 8, 16 or 32 [default with --clusters or --components: 32]
    #[arg(long, value_name = "BITS", value_parser = compression::weight_bits)]
    weights: Option<WeightBits>,
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
    /// It meets nothing
    Unshadowed,
    /// The scene stops it
    Shadowed,
    /// The scene stops it and sends it on
    Interreflected,
    /// The same before it is reflected, as matrices: for surfaces that shine
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

    const fn name(self) -> &'static str {
        match self {
            Self::Unshadowed => "unshadowed",
            Self::Shadowed => "shadowed",
            Self::Interreflected => "interreflected",
            Self::Glossy => "glossy",
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

/// What `--json` prints.
#[derive(Serialize)]
struct Printed<'a> {
    vertices: usize,
    triangles: usize,
    rays: u64,
    seconds: f64,
    stderr_dc: f64,
    points: usize,
    bounces: usize,
    energy_per_bounce: &'a [f64],
    energy_left: f64,
    /// Clusters, components, bytes, bytes before for each of them, relative error.
    #[serde(skip_serializing_if = "Option::is_none")]
    compression: Option<Value>,
}

impl Bake {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.check_options()?;
        output::check_file(&self.output)?;
        let given = self.input.read(talk)?;
        let (scene, is_split) = self.split(given, talk)?;
        let checkpoint = Checkpoint::beside(&self.output);
        if self.fresh {
            checkpoint.discard()?;
        }
        let (report, compression) = if let Some(counts) = self.grid {
            (self.bake_grid(&scene, counts, &checkpoint, talk)?, None)
        } else if let Some(width) = self.texels {
            (self.bake_texels(&scene, width, &checkpoint, talk)?, None)
        } else if self.mode == ModeName::Glossy {
            (self.bake_glossy(&scene, &checkpoint, talk)?, None)
        } else {
            self.bake_vertices(&scene, is_split, &checkpoint, talk)?
        };
        checkpoint.finish();
        self.tell(&scene, &report, compression.as_ref(), talk)
    }

    /// An option that would be ignored is a misunderstanding.
    fn check_options(&self) -> anyhow::Result<()> {
        let is_glossy = self.mode == ModeName::Glossy;
        let has_bounces = is_glossy || self.mode == ModeName::Interreflected;
        let (has_edges, is_compressed) =
            (self.max_edge.is_some() || self.adaptive.is_some(), self.compression().is_some());
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
            (self.min_edge.is_some() && self.adaptive.is_none(), "--min-edge: only of --adaptive"),
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
        BakeOptions {
            mode: self.mode.mode(),
            order: self.order,
            samples: self.samples,
            bounces: self.bounces.unwrap_or(defaults.bounces),
            energy_stop: self.energy_stop.unwrap_or(defaults.energy_stop),
            seed: self.seed,
            channels: None,
        }
    }

    /// The scene with edges split as the options say, and whether any option said so.
    fn split(&self, scene: Scene, talk: Talk) -> anyhow::Result<(Scene, bool)> {
        let mut scene = scene;
        if let Some(max_edge) = self.max_edge {
            scene = scene.split_edges(max_edge as f32)?;
        }
        if let Some(threshold) = self.adaptive {
            let mode = if self.mode == ModeName::Unshadowed { Mode::Unshadowed } else { Mode::Shadowed };
            let options = AdaptiveOptions {
                threshold,
                min_edge: self.min_edge.map_or(diagonal(&scene) * SHORTEST_EDGE, |edge| edge as f32),
                bake: BakeOptions { mode, samples: ADAPTIVE_SAMPLES, ..self.bake_options() },
            };
            let bar = talk.bar("split", 1);
            let (finer, report) = split_adaptively(&scene, &options, &mut |progress| {
                show(&bar, "split", progress);
                ControlFlow::Continue(())
            })?;
            bar.finish_and_clear();
            let (before, after, rounds) = (report.vertices_before, report.vertices, report.rounds);
            let mut text = format!("{after} vertices after {rounds} rounds of splitting, {before} before");
            if report.unresolved > 0 {
                text += &format!("; {} edges still differ by more and are too short to be split", report.unresolved);
            }
            talk.note(&self.input.name(), &text);
            scene = finer;
        }
        Ok((scene, self.max_edge.is_some() || self.adaptive.is_some()))
    }

    fn bake_vertices(
        &self,
        scene: &Scene,
        is_split: bool,
        checkpoint: &Checkpoint,
        talk: Talk,
    ) -> anyhow::Result<(BakeReport, Option<CompressReport>)> {
        // All of the output but for the transfer, so that what is wrong with it shows before the bake.
        let glb = if self.is_glb() { Some(self.glb(scene, is_split, talk)?) } else { None };
        let (receivers, options) = (Receivers::at_vertices(scene)?, self.bake_options());
        let channels = options.channels_for(scene, receivers.is_grey());
        let transfer = bytes(receivers.len(), self.order.pow(2), channels);
        if let Some(glb) = &glb {
            glb.check_size(self.order, channels)?;
        }
        checkpoint.check_room(
            &self.output,
            glb.as_ref().map_or(transfer, |glb| glb.size(self.order, channels)),
            transfer,
        )?;
        let bvh = self.tree(scene, talk);
        let (transfer, report) = checkpoint
            .watched(talk, |path, progress| bake_resumable(scene, &bvh, &receivers, &options, path, progress))?;
        let mut recipe = self.recipe(scene, &report);
        let Some(compression) = self.compression() else {
            match glb {
                Some(glb) => glb.write(&self.output, &transfer, &recipe)?,
                None => write_transfer(&self.output, &transfer, &recipe)?,
            }
            return Ok((report, None));
        };
        let (compressed, saved) = CompressedTransfer::new(&transfer.load()?, &compression)?;
        recipe["relative_error"] = json!(saved.relative_error);
        match glb {
            Some(glb) => glb.write_compressed(&self.output, &compressed, &recipe)?,
            None => write_compressed_transfer(&self.output, &compressed)?,
        }
        Ok((report, Some(saved)))
    }

    fn bake_glossy(&self, scene: &Scene, checkpoint: &Checkpoint, talk: Talk) -> anyhow::Result<BakeReport> {
        let (receivers, options) = (Receivers::at_vertices(scene)?, self.bake_options());
        let bytes = bytes(receivers.len(), self.order.pow(4), options.channels_for(scene, receivers.is_grey()));
        checkpoint.check_room(&self.output, bytes, bytes)?;
        let bvh = self.tree(scene, talk);
        let (matrices, report) = checkpoint.watched(talk, |path, progress| {
            bake_matrices_resumable(scene, &bvh, &receivers, &options, path, progress)
        })?;
        write_matrices(&self.output, &matrices, &self.recipe(scene, &report))?;
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
        let channels = options.channels_for(scene, texels.receivers().is_grey());
        let [picture, receivers] =
            [width * width, texels.receivers().len()].map(|points| bytes(points, self.order.pow(2), channels));
        checkpoint.check_room(&self.output, picture, receivers)?;
        let bvh = self.tree(scene, talk);
        let (transfer, report) = checkpoint.watched(talk, |path, progress| {
            bake_resumable(scene, &bvh, texels.receivers(), &options, path, progress)
        })?;
        let (picture, recipe) = (texels.rows(&transfer)?, self.recipe(scene, &report));
        match has_extension(&self.output, "exr") {
            true => write_lightmap(&self.output, &picture, &recipe)?,
            false => write_transfer(&self.output, &picture, &recipe)?,
        }
        Ok(report)
    }

    /// Refuses a lightmap that takes too much memory: of an .exr picture all numbers, and the file while it grows.
    fn check_memory(&self, scene: &Scene, width: usize) -> anyhow::Result<()> {
        let channels = self.bake_options().channels_for(scene, scene.is_grey());
        let is_picture = has_extension(&self.output, "exr");
        let numbers = if is_picture { 2 * bytes(width * width, self.order.pow(2), channels) } else { 0 };
        let what = format!("--texels {width}");
        self.memory.check(&what, numbers + TEXEL * (width * width) as u64, "fewer --texels, or a lower --order")
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
        checkpoint.check_room(&self.output, bytes, bytes)?;
        let bvh = self.tree(scene, talk);
        let (matrices, report) = checkpoint.watched(talk, |path, progress| {
            bake_neighbourhood_resumable(scene, &bvh, &grid, &options, path, progress)
        })?;
        write_neighbourhood(&self.output, &grid, &matrices, &self.recipe(scene, &report))?;
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

    /// The tree of the scene. What makes it inexact is told.
    fn tree(&self, scene: &Scene, talk: Talk) -> Bvh {
        let bvh = Bvh::new(scene);
        if bvh.offset() > HIGH_START * diagonal(scene) {
            let offset = bvh.offset();
            let text = format!("far from its origin: rays start {offset} above surfaces; move the scene to the origin");
            talk.note(&self.input.name(), &text);
        }
        bvh
    }

    fn compression(&self) -> Option<CompressOptions> {
        if self.clusters.is_none() && self.components.is_none() && self.weights.is_none() {
            return None;
        }
        let mut options = CompressOptions::default();
        options.clusters = self.clusters.unwrap_or(options.clusters);
        options.components = self.components.unwrap_or(options.components);
        options.weights = self.weights.unwrap_or(WeightBits::F32);
        Some(options)
    }

    fn glb(&self, scene: &Scene, is_split: bool, talk: Talk) -> anyhow::Result<BakedGlb> {
        let glb = match self.input.gltf_file() {
            Some(file) if !is_split => BakedGlb::of_file(file, scene)?,
            _ => BakedGlb::of_scene(scene),
        };
        for note in glb.notes() {
            talk.note(&self.input.name(), note);
        }
        if is_split && self.input.gltf_file().is_some() {
            let text =
                "split, so what the file holds beside its triangles, base colours and their textures is left out";
            talk.note(&self.input.name(), text);
        }
        Ok(glb)
    }

    /// Everything that decides the bytes of the output, and nothing that differs from run to run.
    fn recipe(&self, scene: &Scene, report: &BakeReport) -> Value {
        let mut fingerprint = Fingerprint::of_kind(0);
        fingerprint.scene(scene);
        let options = self.bake_options();
        let compression = self.compression();
        json!({
            "scene": self.input.file_name(),
            "scene_hash": fingerprint.bits().map(|bits| format!("{bits:016x}")).concat(),
            "mode": self.mode.name(),
            "order": options.order,
            "samples": options.samples,
            "bounces": if options.mode == Mode::Interreflected { options.bounces } else { 0 },
            "bounces_baked": report.bounces,
            "energy_stop": options.energy_stop,
            "seed": options.seed,
            "max_edge": self.max_edge,
            "adaptive": self.adaptive,
            "min_edge": self.min_edge,
            "texels": self.texels,
            "grid": self.grid,
            "grid_box": self.grid_box,
            "clusters": compression.map(|options| options.clusters),
            "components": compression.map(|options| options.components),
            "weights": compression.map(|options| 8 * options.weights.bytes()),
            "rays": report.rays,
            "stderr_dc": report.stderr_dc,
            "versions": {"lobe": env!("CARGO_PKG_VERSION")},
        })
    }

    fn tell(
        &self,
        scene: &Scene,
        report: &BakeReport,
        compression: Option<&CompressReport>,
        talk: Talk,
    ) -> anyhow::Result<()> {
        if self.json {
            return output::print_json(&Printed {
                vertices: scene.vertex_count(),
                triangles: scene.triangle_count(),
                points: report.receivers,
                rays: report.rays,
                seconds: report.seconds,
                stderr_dc: report.stderr_dc,
                bounces: report.bounces,
                energy_per_bounce: &report.energy_per_bounce,
                energy_left: report.energy_left,
                compression: compression.map(|saved| {
                    json!({
                        "clusters": saved.clusters, "components": saved.components, "bytes": saved.bytes,
                        "ratio": saved.ratio(), "relative_error": saved.relative_error,
                    })
                }),
            });
        }
        let mut text = format!(
            "{} points, {} triangles; {} rays in {:.1} s; standard error of the constant coefficient {:.2} %",
            report.receivers,
            scene.triangle_count(),
            report.rays,
            report.seconds,
            100.0 * report.stderr_dc
        );
        if self.bake_options().mode == Mode::Interreflected {
            let all = report.energy_left + report.energy_per_bounce.iter().sum::<f64>();
            let left = if all > 0.0 { 100.0 * report.energy_left / all } else { 0.0 };
            text += &format!("; {} bounces, at most {left:.2} % of the light goes on", report.bounces);
        }
        if let Some(saved) = compression {
            text += &format!("; compressed {:.1} : 1 at {:.2} % error", saved.ratio(), 100.0 * saved.relative_error);
        }
        talk.note(&self.output.display().to_string(), &text);
        Ok(())
    }
}

/// What so many points take with so many numbers for a channel.
fn bytes(points: usize, numbers: usize, channels: Channels) -> u64 {
    (points as u64).saturating_mul((4 * numbers * channels.count()) as u64)
}

/// The length of the diagonal of the scene's box.
fn diagonal(scene: &Scene) -> f32 {
    let Bounds { min, max } = scene.bounds();
    (0..3).map(|k| (max[k] - min[k]).powi(2)).sum::<f32>().sqrt()
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}
