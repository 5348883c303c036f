//! The options of `lobe bake`, and what of them cannot be had together.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use lobe::prt::{AlbedoMode, BakeMode, BakeOptions, Transfer};
use lobe::scene::Scene;

use crate::args::compression::Compression;
use crate::args::memory::MemoryLimit;
use crate::args::names::names;
use crate::args::output::has_extension;
use crate::args::scene_input::SceneInput;
use crate::args::sharing::Sharing;
use crate::args::values;
use crate::bake::split::Splitting;
use crate::bake::texels::LightmapOptions;

const NOTES: &str = "\
Stopping: results are kept in OUT.checkpoint, those of splitting in OUT.checkpoint.split-0, -1 and so on. Ctrl-C (or \
SIGTERM, SIGHUP) ends the bake with exit code 2 and leaves these files, and so does whatever kills it, at a cost of at \
most 10 s of rays. The same command reads the scene, splits it where that is known already, and goes on from there, to \
the same bytes; at the end the files are removed. Compression begins anew.

Disk: 12 n² bytes for each triangle and channel, taken from the start, and 4 n² for each vertex and channel of the \
output; n⁴ instead of n² of --mode glossy; of --texels and --grid twice the output.

Memory: 20 MB, and at vertices 2200 bytes for each of the scene once split, or, if that is more, 1250 and 20 n² for \
each channel; of --mode glossy 4 n⁴ for each channel, and up to 0.8 GB beside. Compression takes twice 4 n² bytes for \
each vertex and channel. --texels takes 820 bytes for each vertex and 105 for each texel, and 12 n² for each channel, \
as .exr 20 n²; unwrapping takes 1000 bytes for each triangle.";

#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Args)]
#[command(after_help = NOTES)]
pub(crate) struct Bake {
    #[command(flatten)]
    pub(super) input: SceneInput,
    /// The scene with transfer at its vertices, or in textures with --texels, a .glb file; or the transfer alone, a
    /// .safetensors file, as which --mode glossy and --grid are written; of --texels also an .exr picture with a layer
    /// for each coefficient
    #[arg(short, long, value_name = "OUT")]
    pub(super) output: PathBuf,
    /// The light that is baked
    #[arg(long, value_enum, default_value = "interreflected")]
    pub(super) mode: ModeName,
    /// The order (number of bands), 1 to 8: n² coefficients, three times as many where light meets colors
    #[arg(long, value_name = "N", default_value = "4", value_parser = order)]
    pub(super) order: usize,
    /// Paths from each vertex, 1 to 16777216; powers of two are distributed best [default: 1024, or up to 4096 where
    /// their noise is above 2 %]
    #[arg(long, value_name = "N", value_parser = samples)]
    pub(super) samples: Option<u32>,
    /// With --mode interreflected and glossy: reflections at most, 0 to 255 [default: 3]
    #[arg(long, value_name = "B", value_parser = bounces)]
    pub(super) bounces: Option<usize>,
    /// With --mode interreflected and glossy: leave out reflections that carry less than this part of the energy; 0 keeps all [default: 0.001]
    #[arg(long, value_name = "X", value_parser = part)]
    pub(super) energy_stop: Option<f64>,
    /// The same seed gives the same bytes
    #[arg(long, value_name = "S", default_value = "0")]
    pub(super) seed: u64,
    /// Where the albedo of the surface itself is; not of --mode glossy and --grid, whose matrices never have it
    /// [default: none if a texture colors any surface, else vertex]
    #[arg(long, value_enum)]
    pub(super) albedo: Option<AlbedoName>,
    /// Keep the transfer of the backs of double-sided surfaces in the file, too, for the side from which corners run
    /// clockwise. Without it lobe render bakes those that it shows, and other programs have none. Of a .glb without
    /// compression
    #[arg(long, conflicts_with_all = ["texels", "grid", "clusters", "components", "weights", "shard", "merge"])]
    pub(super) backs: bool,
    #[command(flatten)]
    pub(super) splitting: Splitting,
    /// Bake at the W × W texels of a lightmap instead of at vertices, with the normals that normal maps have there, in
    /// texture coordinates of set 1 or else 0 that do not overlap, or of an unwrapping
    #[arg(long, value_name = "W", value_parser = texels, conflicts_with_all = ["grid", "clusters", "components", "weights"])]
    pub(super) texels: Option<usize>,
    #[command(flatten)]
    pub(super) lightmap: LightmapOptions,
    /// Bake the light that arrives at points in space, as matrices: NX × NY × NZ points in the scene's box
    #[arg(long, value_name = "NX,NY,NZ", value_parser = grid, conflicts_with_all = ["clusters", "components", "weights"])]
    pub(super) grid: Option<[usize; 3]>,
    /// With --grid: two corners of the box, whose corners are points [default: the scene's box, with points in the middle of
    /// as many equal parts]
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1", value_parser = values::numbers::<6>, requires = "grid", allow_hyphen_values = true)]
    pub(super) grid_box: Option<[f64; 6]>,
    #[command(flatten)]
    pub(super) compression: Compression,
    #[command(flatten)]
    pub(super) memory: MemoryLimit,
    /// Start anew, even if there is a checkpoint of a bake that was stopped
    #[arg(long)]
    pub(super) fresh: bool,
    /// Print {"vertices", "triangles", "rays", "seconds", "stderr_dc", "points", "samples", "bounces",
    /// "energy_per_bounce", "energy_left"} on stdout, of compressed transfer also "compression": {"clusters",
    /// "components", "bytes", "ratio", "relative_error"}; with --shard {"shard", "points", "points_in_all", "seconds"}
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    pub(super) sharing: Sharing,
}

names! {
    pub(super) enum ModeName for BakeMode {
        /// Light that meets nothing on its way
        Unshadowed,
        /// Light that the scene may block
        Shadowed,
        /// Light that the scene may block, and that its surfaces reflect
        Interreflected,
        /// The same light before a vertex reflects it, as matrices: for glossy surfaces
        Glossy,
    }
}

names! {
    pub(super) enum AlbedoName for AlbedoMode {
        /// In the transfer: what is shown has the detail of vertices
        Vertex,
        /// Nowhere: lobe render, or your shader, multiplies by the base color of each pixel, with the detail of textures
        None,
    }
}

fn order(text: &str) -> Result<usize, String> {
    values::whole(text, 1, Transfer::MAX_ORDER, "an order (number of bands)")
}

fn samples(text: &str) -> Result<u32, String> {
    values::whole(text, 1, BakeOptions::MAX_SAMPLES as usize, "a number of paths").map(|n| n as u32)
}

fn bounces(text: &str) -> Result<usize, String> {
    values::whole(text, 0, BakeOptions::MAX_BOUNCES, "a number of reflections")
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
    /// Refuses options that would be ignored.
    pub(super) fn check_options(&self) -> anyhow::Result<()> {
        let is_glossy = self.mode == ModeName::Glossy;
        let has_bounces = BakeMode::from(self.mode).reflects();
        let (has_edges, is_compressed) = (self.splitting.is_asked(), self.compression.options().is_some());
        let is_elsewhere = self.texels.is_some() || self.grid.is_some();
        let ignored = [
            (self.bounces.is_some() && !has_bounces, "--bounces: only of --mode interreflected and glossy"),
            (self.energy_stop.is_some() && !has_bounces, "--energy-stop: only of --mode interreflected and glossy"),
            (has_edges && is_elsewhere, "--max-edge and --adaptive: light is not at vertices with --texels and --grid"),
            (is_glossy && is_elsewhere, "--mode glossy: at vertices only; --grid bakes matrices by itself"),
            (
                self.albedo == Some(AlbedoName::None) && (is_glossy || self.grid.is_some()),
                "--albedo none: matrices never have the albedo; leave it out",
            ),
            (is_glossy && is_compressed, "--clusters, --components and --weights: not of --mode glossy"),
            (
                self.is_glb() && (is_glossy || self.grid.is_some()),
                "-o: --mode glossy and --grid are written as .safetensors",
            ),
        ];
        if self.backs && !self.is_glb() {
            bail!("--backs: only of a .glb, which holds the sides of its surfaces; leave the option out");
        }
        self.sharing.check(&self.output)?;
        if let Some((_, message)) = ignored.into_iter().find(|(is_ignored, _)| *is_ignored) {
            bail!(message);
        }
        let is_picture = has_extension(&self.output, "exr");
        if self.texels.is_some() && !is_picture && !self.is_glb() && !has_extension(&self.output, "safetensors") {
            bail!("{}: expected a name that ends in .glb, .safetensors or .exr", self.output.display());
        }
        if self.texels.is_none() && !self.is_glb() && !has_extension(&self.output, "safetensors") {
            bail!("{}: expected a name that ends in .glb or .safetensors", self.output.display());
        }
        Ok(())
    }

    /// Whether triangles are split where transfer is off: of a scene that the output, or that of all shards, holds too.
    pub(super) fn is_split(&self) -> bool {
        let is_at_vertices = self.texels.is_none() && self.grid.is_none();
        let has_scene = (self.is_glb() || self.sharing.shard.is_some()) && self.mode != ModeName::Glossy;
        let is_left_open = has_scene && self.splitting.max_edge.is_none() && !self.splitting.budget.no_split;
        is_at_vertices && (is_left_open || self.splitting.is_adaptive_asked())
    }

    pub(super) fn is_glb(&self) -> bool {
        has_extension(&self.output, "glb")
    }

    pub(super) fn bake_options(&self, scene: &Scene) -> BakeOptions {
        let defaults = BakeOptions::default();
        let has_matrices = self.mode == ModeName::Glossy || self.grid.is_some();
        let own = || if has_matrices { defaults.albedo } else { AlbedoMode::of_scene(scene) };
        let mut options = defaults
            .clone()
            .mode(self.mode.into())
            .order(self.order)
            .bounces(self.bounces.unwrap_or(defaults.bounces))
            .energy_stop(self.energy_stop.unwrap_or(defaults.energy_stop))
            .seed(self.seed)
            .albedo(self.albedo.map_or_else(own, Into::into));
        options.samples = self.samples;
        options
    }
}
