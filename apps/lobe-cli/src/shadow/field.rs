//! `lobe field`: the occlusion field of an entity, for shadows that it casts wherever it moves.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use lobe::scene::{EntityKind, Mesh, Scene};
use lobe::shadow::{
    FieldOptions, FieldReport, FieldStorage, StorageReport, SurfaceVisibility, VisibilityOptions, bake_field,
    bake_field_shard, bake_vertex_visibility, write_field, write_visibility,
};
use serde::Serialize;

use crate::args::field_storage::StorageOptions;
use crate::args::memory::MemoryLimit;
use crate::args::open_scene::OpenScene;
use crate::args::output;
use crate::args::scene_input::SceneInput;
use crate::args::sharing::{self, Sharing};
use crate::args::values;
use crate::run::bake_watch::{Checkpoint, tell_if_too_late};
use crate::run::talk::Talk;

/// Limits of the options. Larger numbers are taken for typing errors.
const MAX_SPHERES: usize = 256;
const MAX_CELLS: usize = 256;
const MAX_RAYS: usize = 1 << 20;

/// What is said of a scene that is posed.
const IF_POSED: &str = "this field does not follow; --entity NAME bakes that of one part in its own frame";

/// How often all numbers are held at once.
const COPIES: u64 = 3;

#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Args)]
pub(crate) struct Field {
    #[command(flatten)]
    input: SceneInput,
    /// The field, a .safetensors file
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Only this entity of a scene: a mesh, or a node of a glTF file, by name or number; in its own frame, which moves with it, and in the shape
    /// that its skin was bound to
    #[arg(long, value_name = "NAME")]
    entity: Option<String>,
    /// Number of bands, 1 to 8
    #[arg(long, value_name = "N", default_value = "4", value_parser = order)]
    order: usize,
    /// Concentric spheres of sample points around the entity, 2 or more [default: 16]
    #[arg(long, value_name = "N", value_parser = spheres)]
    spheres: Option<usize>,
    /// Cells along each side of the octahedral grid of sample points on a sphere, an even number [default: 16]
    #[arg(long, value_name = "N", value_parser = cells)]
    cells: Option<usize>,
    /// The innermost and the outermost sphere, in radii of the entity [default: 0.25,8]
    #[arg(long, value_name = "INNER,OUTER", value_parser = range)]
    range: Option<[f64; 2]>,
    /// Rays from each sample point, 1 to 1048576 [default: 1024]
    #[arg(long, value_name = "N", value_parser = rays)]
    rays: Option<u32>,
    /// Another seed gives other rays
    #[arg(long, value_name = "S", default_value = "0")]
    seed: u64,
    /// Write instead what each vertex sees of the sky past the entity itself: its own visibility, by which those that other entities leave are
    /// multiplied
    #[arg(long, conflicts_with_all = ["spheres", "cells", "range", "shard", "merge"])]
    self_visibility: bool,
    #[command(flatten)]
    storage: StorageOptions,
    #[command(flatten)]
    memory: MemoryLimit,
    /// Start anew, even if there is a checkpoint of a bake that was stopped
    #[arg(long)]
    fresh: bool,
    /// Print {"points", "inside", "rays", "storage": {"bytes", "bytes_before", "relative_error", "largest_error"}} on stdout; with
    /// --self-visibility "vertices" instead of the first two
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    sharing: Sharing,
}

pub(crate) fn order(text: &str) -> Result<usize, String> {
    values::whole(text, 1, 8, "an order (number of bands)")
}

pub(crate) fn spheres(text: &str) -> Result<usize, String> {
    values::whole(text, 2, MAX_SPHERES, "a number of spheres")
}

pub(crate) fn cells(text: &str) -> Result<usize, String> {
    match values::whole(text, 2, MAX_CELLS, "a number of cells")? {
        odd if odd % 2 == 1 => Err(format!("expected an even number of cells, found {odd}")),
        even => Ok(even),
    }
}

fn rays(text: &str) -> Result<u32, String> {
    values::whole(text, 1, MAX_RAYS, "a number of rays").map(|n| n as u32)
}

pub(crate) fn range(text: &str) -> Result<[f64; 2], String> {
    match values::numbers::<2>(text)? {
        [inner, outer] if 0.0 < inner && inner < outer => Ok([inner, outer]),
        [inner, outer] => Err(format!("expected radii above 0 that rise, found {inner},{outer}")),
    }
}

/// Sample points of a grid.
fn points(spheres: usize, cells: usize) -> usize {
    (cells + 1).pow(2) * spheres + 1
}

/// The most bytes of the rows of sample points while they are baked and written.
pub(crate) fn bytes(order: usize, spheres: usize, cells: usize) -> u64 {
    COPIES * size_of::<f32>() as u64 * (points(spheres, cells) * order * (order + 1)) as u64
}

/// The JSON of `--json`.
#[derive(Serialize)]
struct Printed {
    points: usize,
    inside: usize,
    rays: u64,
    storage: StorageReport,
}

/// The same with `--self-visibility`.
#[derive(Serialize)]
struct PrintedVisibility {
    vertices: usize,
    rays: u64,
    storage: StorageReport,
}

impl Field {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        output::check_safetensors(&self.output)?;
        let form = self.storage.form()?;
        let inputs: Vec<_> = self.sharing.inputs().chain([self.input.path()]).collect();
        output::prepare_file(&self.output, &inputs)?;
        let scene = self.occluder(talk)?;
        let checkpoint = self.sharing.checkpoint(&self.output);
        if self.fresh {
            checkpoint.discard()?;
        }
        if self.self_visibility {
            return self.bake_self_visibility(&scene, &checkpoint, &form, talk);
        }
        let options = self.options();
        self.check_memory(&options)?;
        if let Some(shard) = self.sharing.shard {
            let begin = Instant::now();
            let [points, points_in_all] =
                checkpoint.watched(talk, |job| bake_field_shard(&scene, &options, shard, job))?;
            let (shard, seconds) = (shard.to_string(), begin.elapsed().as_secs_f64());
            return sharing::Done { shard, points, points_in_all, seconds }.tell(&self.output, self.json, talk);
        }
        self.sharing.merge(&checkpoint, talk)?;
        let baked = checkpoint.watched(talk, |job| bake_field(&scene, &options, job));
        let (field, report) = self.sharing.merged(&checkpoint, baked)?;
        let storage = write_field(&self.output, &field, &form)?;
        self.storage.tell_if_larger(&storage, talk);
        checkpoint.finish();
        tell_if_too_late(&self.output, talk);
        let FieldReport { points, inside, rays, .. } = report;
        let printed = Printed { points, inside, rays, storage };
        if self.json { output::print_json(&printed) } else { output::print(&printed.to_text()) }
    }

    /// What hides the sky: the scene, or one entity of it.
    fn occluder(&self, talk: Talk) -> anyhow::Result<Scene> {
        let opened = OpenScene::of_shapes(&self.input, &self.memory, talk)?;
        let (scene, entity) = opened.whole_or_entity(self.entity.as_deref(), IF_POSED)?;
        if entity.is_some_and(|(_, entity)| entity.kind() == EntityKind::Deformed) {
            let text = "this entity is deformed by a skin or by morph targets, which its field does not follow; spheres do: \
                        lobe spheres --entity";
            talk.note(&self.input.name(), text);
        }
        Ok(scene)
    }

    fn bake_self_visibility(
        &self,
        scene: &Scene,
        checkpoint: &Checkpoint,
        form: &FieldStorage,
        talk: Talk,
    ) -> anyhow::Result<()> {
        let vertices = scene.vertex_count();
        let what = format!("the visibility of {vertices} vertices at order {}", self.order);
        let numbers = vertices * self.order * self.order;
        self.memory.check(&what, COPIES * size_of::<f32>() as u64 * numbers as u64, "fewer bands (--order)")?;
        let defaults = VisibilityOptions::default();
        let rays = self.rays.unwrap_or(defaults.rays);
        let options = defaults.order(self.order).rays(rays).seed(self.seed);
        let (rows, rays) = checkpoint.watched(talk, |job| bake_vertex_visibility(scene, &options, job))?;
        let positions = scene.meshes().iter().flat_map(Mesh::positions).copied().collect();
        let visibility = SurfaceVisibility::new(self.order, rows)?.with_positions(positions)?;
        let storage = write_visibility(&self.output, &visibility, form)?;
        self.storage.tell_if_larger(&storage, talk);
        checkpoint.finish();
        tell_if_too_late(&self.output, talk);
        if self.json {
            return output::print_json(&PrintedVisibility { vertices, rays, storage });
        }
        output::print(&format!("vertices        {vertices}\nrays            {rays}\n{}", text_of_storage(&storage)))
    }

    fn options(&self) -> FieldOptions {
        let defaults = FieldOptions::default();
        let [inner, outer] = self.range.unwrap_or([defaults.inner, defaults.outer]);
        defaults
            .clone()
            .order(self.order)
            .spheres(self.spheres.unwrap_or(defaults.spheres))
            .cells(self.cells.unwrap_or(defaults.cells))
            .inner(inner)
            .outer(outer)
            .rays(self.rays.unwrap_or(defaults.rays))
            .seed(self.seed)
    }

    /// Rows are held as they are made and as a field, then as a field, encoded, and decoded for the report.
    fn check_memory(&self, options: &FieldOptions) -> anyhow::Result<()> {
        let FieldOptions { order, spheres, cells, .. } = *options;
        let what = format!("a field of {} sample points at order {order}", points(spheres, cells));
        self.memory.check(&what, bytes(order, spheres, cells), "fewer --spheres or --cells")
    }
}

impl Printed {
    fn to_text(&self) -> String {
        let Self { points, inside, rays, storage } = self;
        let storage = text_of_storage(storage);
        format!("sample points   {points}, {inside} inside the solid\nrays            {rays}\n{storage}")
    }
}

fn text_of_storage(storage: &StorageReport) -> String {
    format!("bytes           {}\nrelative error  {:.3e} of storage\n", storage.bytes, storage.relative_error)
}
