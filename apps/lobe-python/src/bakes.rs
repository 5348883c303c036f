//! Bakes: what a scene does to light, at its vertices, its texels or points in space.

use std::fs;
use std::path::{Path, PathBuf};

use lobe::io::Job;
use lobe::prt::{
    AdaptiveOptions, AdaptiveReport, AlbedoMode, AnyTransfer, BakeMode, BakeOptions, BakeReport, BakeWork, BakedGlb,
    CompressOptions, CompressedTransfer, FinishOptions, Pilot, PrtError, Recipe, TexelReceivers, read_any_transfer,
    read_baked, scene_hash, split_checkpoints, write_compressed_transfer, write_half_transfer, write_transfer,
    write_zonal_transfer,
};
use lobe::scene::{GltfDocument, Scene, ScenePose, SceneReadOptions, UnwrapOptions};
use lobe::sh::Rgb;
use numpy::{PyArrayDyn, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::compression::{compress_options, report_of_compression};
use crate::forked::with_threads;
use crate::job::{answered, error_of, watched};
use crate::outputs::{beside, has_ending, prepare};
use crate::rows::{array_of, contiguous, value_error};
use crate::scenes::{Read, SceneInput};
use crate::sharing::{merge, of_merged, shard_of};

/// The options of a bake, whose ranges the package has checked.
#[derive(Clone, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Settings {
    mode: String,
    order: usize,
    samples: Option<u32>,
    bounces: usize,
    energy_stop: f64,
    seed: u64,
    albedo: Option<String>,
    max_edge: Option<f64>,
    texels: Option<usize>,
    unwrap: String,
    denoise: bool,
    grid: Option<[usize; 3]>,
    grid_box: Option<[f64; 6]>,
    /// Whether triangles are split where transfer is off; of shards as soon as the scene is read.
    split: bool,
    is_shared: bool,
    adaptive: Option<f64>,
    min_edge: Option<f64>,
    max_vertices: Option<usize>,
    /// Compressed if any of these is given.
    clusters: Option<usize>,
    components: Option<usize>,
    weights: Option<usize>,
}

/// A scene whose light can be baked, where, and how.
#[pyclass(frozen, module = "lobe")]
pub(crate) struct Bake {
    name: String,
    /// Where the scene was read, which no result may replace.
    source: SceneInput,
    work: BakeWork,
    /// All that a glTF file holds.
    document: Option<GltfDocument>,
    /// The pose of the scene, if its file poses it.
    pose: Option<ScenePose>,
    settings: Settings,
    /// How the scene of shards was split.
    split: Option<SplitBy>,
}

/// How a scene was split, and what came of it.
type SplitBy = (AdaptiveOptions, AdaptiveReport);

pub(crate) fn mode_of(name: &str) -> PyResult<BakeMode> {
    let all = [BakeMode::Unshadowed, BakeMode::Shadowed, BakeMode::Interreflected, BakeMode::Glossy];
    let found = all.into_iter().find(|mode| mode.name() == name);
    found.ok_or_else(|| {
        value_error(format!("mode: expected unshadowed, shadowed, interreflected or glossy, found {name:?}"))
    })
}

impl Settings {
    fn options(&self) -> PyResult<BakeOptions> {
        let mut options = BakeOptions::default().mode(mode_of(&self.mode)?).order(self.order);
        options.samples = self.samples;
        Ok(options.bounces(self.bounces).energy_stop(self.energy_stop).seed(self.seed))
    }

    /// Where the albedo of a scene's surfaces is. Matrices never have it.
    fn albedo(&self, scene: &Scene) -> AlbedoMode {
        let has_matrices = self.grid.is_some() || self.mode == BakeMode::Glossy.name();
        match self.albedo.as_deref() {
            Some("none") => AlbedoMode::None,
            None if !has_matrices => AlbedoMode::of_scene(scene),
            _ => AlbedoMode::Vertex,
        }
    }

    /// How triangles of the scene of a work are split.
    fn splitting(&self, work: &BakeWork) -> PyResult<AdaptiveOptions> {
        let found = work.scene().vertex_count();
        if self.max_vertices.is_some_and(|most| most < found) {
            let text = format!("max_vertices: expected at least the {found} vertices that the scene begins with");
            return Err(value_error(text));
        }
        let defaults = AdaptiveOptions::default().bake(work.options().clone());
        let error = self.adaptive.unwrap_or(defaults.error);
        Ok(defaults.error(error).min_edge(self.min_edge.map(|edge| edge as f32)).max_vertices(self.max_vertices))
    }

    fn work(&self, scene: Scene, options: BakeOptions) -> Result<BakeWork, PrtError> {
        match (self.texels, self.grid) {
            (Some(width), _) => self.work_at_texels(scene, width, options),
            (None, Some(counts)) => BakeWork::in_grid(scene, counts, self.grid_box, options),
            (None, None) => BakeWork::at_vertices(scene, options),
        }
    }

    /// Unwraps the scene, if it is to be.
    fn work_at_texels(&self, scene: Scene, width: usize, options: BakeOptions) -> Result<BakeWork, PrtError> {
        let is_own = match &*self.unwrap {
            "never" => true,
            "always" => false,
            _ => TexelReceivers::check(&scene, width).is_ok(),
        };
        let unwrap = (!is_own).then(|| UnwrapOptions::default().texels(width));
        let scene = match &unwrap {
            Some(unwrap) => scene.unwrapped(unwrap, Job::default())?.0,
            None => scene,
        };
        let finish = FinishOptions::default().denoise(self.denoise);
        Ok(BakeWork::at_texels(scene, width, options)?.finished_by(finish).unwrapped_by(unwrap))
    }

    fn endings(&self) -> &'static [&'static str] {
        match (self.texels, self.grid) {
            (Some(_), _) => &["glb", "safetensors", "exr"],
            (None, Some(_)) => &["safetensors"],
            (None, None) if self.mode == BakeMode::Glossy.name() => &["safetensors"],
            (None, None) => &["glb", "safetensors"],
        }
    }

    /// How results are compressed, if they are.
    fn compression(&self) -> PyResult<Option<CompressOptions>> {
        if self.clusters.is_none() && self.components.is_none() && self.weights.is_none() {
            return Ok(None);
        }
        compress_options(self.clusters, self.components, self.weights).map(Some)
    }
}

impl Bake {
    /// Bakes, with results kept in `checkpoint` until the output is written.
    fn write_with<'py>(
        &self,
        py: Python<'py>,
        (work, split): (&BakeWork, Option<&SplitBy>),
        output: &Path,
        checkpoint: &Path,
        progress: Option<&Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        self.check_output(output.to_path_buf())?;
        // Of texels work writes a .glb by itself.
        let is_glb = has_ending(output, "glb") && self.settings.texels.is_none();
        let glb = if is_glb { Some(self.glb(work).map_err(|error| error_of(&error))?) } else { None };
        let compression = self.settings.compression()?;
        let (baked, report) = watched(py, progress, Some(checkpoint), |job| work.bake(job))?;
        let recipe = self.recipe(work, &report, (split, compression.as_ref()));
        let told = report_of(py, &report)?;
        match compression {
            None => watched(py, progress, None, |job| match (&glb, baked.as_transfer()) {
                (Some(glb), Some(transfer)) => glb.write(output, transfer, &recipe, job),
                _ => work.write(output, &baked, &recipe, job),
            })?,
            Some(options) => {
                let loaded = baked.into_transfer().map_err(|error| error_of(&error))?;
                let transfer = loaded.ok_or_else(|| value_error("clusters: of transfer vectors only"))?;
                let (compressed, saved) =
                    watched(py, progress, None, |job| CompressedTransfer::new(&transfer, &options, job))?;
                let recipe = recipe.relative_error(saved.relative_error);
                let written = py.detach(|| match glb {
                    Some(glb) => glb.write_compressed(output, &compressed, &recipe),
                    None => write_compressed_transfer(output, &compressed, &recipe),
                });
                written.map_err(|error| error_of(&error))?;
                told.set_item("compression", report_of_compression(py, &saved)?)?;
            }
        }
        // The results are safe; a checkpoint that stays is taken up by the same bake.
        let _ = fs::remove_file(checkpoint);
        Ok(told)
    }

    /// Everything that decides the bytes of the output.
    fn recipe(
        &self,
        work: &BakeWork,
        report: &BakeReport,
        (split, compression): (Option<&SplitBy>, Option<&CompressOptions>),
    ) -> Recipe {
        let Settings { max_edge, min_edge, .. } = self.settings;
        let recipe = work.recipe(report).scene(self.name.clone()).max_edge(max_edge);
        let recipe = if self.source.options.straight_through { recipe.straight_through(true) } else { recipe };
        let recipe = self.pose.iter().fold(recipe, Recipe::posed);
        let recipe = split.iter().fold(recipe, |recipe, (options, report)| recipe.split_by(options, report));
        let recipe = recipe.min_edge(min_edge);
        recipe
            .clusters(compression.map(|options| options.clusters))
            .components(compression.map(|options| options.components))
            .weights(compression.map(|options| 8 * options.weights.bytes()))
    }

    /// The scene with further vertices where its transfer is off, and how it was split.
    fn split(&self, py: Python<'_>, checkpoint: &Path, progress: Option<&Py<PyAny>>) -> PyResult<(Scene, SplitBy)> {
        let options = self.settings.splitting(&self.work)?;
        let (scene, report) = watched(py, progress, Some(checkpoint), |job| self.work.split(&options, job))?;
        Ok((scene, (options, report)))
    }
}

fn report_of_split<'py>(py: Python<'py>, report: &AdaptiveReport) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("rounds", report.rounds)?;
    all.set_item("vertices_before", report.vertices_before)?;
    all.set_item("vertices", report.vertices)?;
    all.set_item("rays", report.rays)?;
    all.set_item("error", report.error)?;
    all.set_item("error_bound", report.error_bound)?;
    all.set_item("too_short", report.too_short)?;
    Ok(all)
}

#[pymethods]
impl Bake {
    /// Reads a scene. Options that are out of range are refused by the bake.
    #[new]
    fn new(py: Python<'_>, scene: SceneInput, settings: Settings) -> PyResult<Self> {
        let options = settings.options()?;
        let (source, asked) = (scene.clone(), settings.clone());
        let made = answered(py, usize::MAX, move || {
            let Read { found: (mut found, document, pose), remarks } = source.with_document()?;
            if let Some(max_edge) = asked.max_edge {
                found = found.split_edges(max_edge as f32)?;
            }
            let options = options.albedo(asked.albedo(&found));
            Ok(Read { found: (asked.work(found, options)?, document, pose), remarks })
        })?;
        let (mut work, document, pose) = made.map_err(|error: PrtError| error_of(&error))?.told(py)?;
        let mut split = None;
        if settings.split && settings.is_shared {
            let splitting = settings.splitting(&work)?;
            let (scene, report) = watched(py, None, None, |job| work.split(&splitting, job))?;
            let options = work.options().clone();
            let again = py.detach(|| with_threads(|| BakeWork::at_vertices(scene, options)));
            (work, split) = (again.map_err(|error| error_of(&error))?, Some((splitting, report)));
        }
        let name = scene.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, source: scene, work, document, pose, settings, split })
    }

    /// The fingerprint of all of the scene that decides the results, 32 hexadecimal digits.
    #[getter]
    fn scene_hash(&self, py: Python<'_>) -> String {
        py.detach(|| scene_hash(self.work.scene()))
    }

    /// The number of points: vertices, texels that are seen, or points in space.
    #[getter]
    fn points(&self) -> usize {
        self.work.points()
    }

    /// Bytes of all results.
    #[getter]
    fn bytes(&self) -> u64 {
        self.work.bytes()
    }

    /// What the pilot has found, bounces, paths and an error; none before the first shard.
    #[getter]
    fn pilot(&self) -> Option<(usize, u32, f64)> {
        self.work.pilot().map(|Pilot { bounces, samples, stderr_dc }| (bounces, samples, stderr_dc))
    }

    /// Takes what the pilot of the same bake has found elsewhere.
    fn know(&self, pilot: (usize, u32, f64)) -> PyResult<()> {
        let (bounces, samples, stderr_dc) = pilot;
        self.work.know(Pilot { bounces, samples, stderr_dc }).map_err(|error| error_of(&error))
    }

    /// Refuses the name of a file that cannot hold the results, and that of the scene, which would be lost.
    #[expect(clippy::needless_pass_by_value, reason = "extracted from an argument of Python")]
    fn check_output(&self, output: PathBuf) -> PyResult<()> {
        prepare(&output, self.settings.endings(), &[&self.source.path])
    }

    /// Bakes, with results kept beside the output until it is written.
    fn write<'py>(
        &self,
        py: Python<'py>,
        output: PathBuf,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (checkpoint, progress) = (beside(&output, ".checkpoint"), progress.as_ref());
        if !self.settings.split {
            return self.write_with(py, (&self.work, None), &output, &checkpoint, progress);
        }
        self.check_output(output.clone())?;
        let (scene, split) = self.split(py, &checkpoint, progress)?;
        let work = py.detach(|| with_threads(|| BakeWork::at_vertices(scene, self.work.options().clone())));
        let work = work.map_err(|error| error_of(&error))?;
        let report = self.write_with(py, (&work, Some(&split)), &output, &checkpoint, progress)?;
        // The last first, so that what is left by a fault has no gaps.
        for path in split_checkpoints(&checkpoint).iter().rev() {
            let _ = fs::remove_file(path);
        }
        report.set_item("adaptive", report_of_split(py, &split.1)?)?;
        Ok(report)
    }

    /// Bakes a shard, which is the file that it is kept in.
    fn write_shard<'py>(
        &self,
        py: Python<'py>,
        output: PathBuf,
        number: u32,
        count: u32,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let shard = shard_of(number, count)?;
        let report = watched(py, progress.as_ref(), Some(&output), |job| self.work.bake_shard(shard, job))?;
        report_of(py, &report)
    }

    /// Puts shards together and writes the output: the bytes that one machine alone gives it.
    fn merge<'py>(
        &self,
        py: Python<'py>,
        parts: Vec<PathBuf>,
        output: PathBuf,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let inputs: Vec<&Path> = parts.iter().chain([&self.source.path]).map(PathBuf::as_path).collect();
        prepare(&output, self.settings.endings(), &inputs)?;
        // Beside what a bake that was stopped may have kept.
        let checkpoint = beside(&output, ".merged.checkpoint");
        merge(py, &parts, &checkpoint, progress.as_ref())?;
        self.write_with(py, (&self.work, self.split.as_ref()), &output, &checkpoint, progress.as_ref())
            .map_err(|error| of_merged(py, error, &parts, &checkpoint))
    }
}

impl Bake {
    /// The scene that the results become part of, which has to have room for them.
    fn glb(&self, work: &BakeWork) -> Result<BakedGlb, PrtError> {
        let scene = work.scene();
        let glb = match &self.document {
            Some(document) => BakedGlb::of_document(document.clone(), scene)?,
            None => BakedGlb::of_scene(scene),
        };
        glb.check_size(work.options().order, work.channels())?;
        Ok(glb)
    }
}

fn report_of<'py>(py: Python<'py>, report: &BakeReport) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("receivers", report.receivers)?;
    all.set_item("rays", report.rays)?;
    all.set_item("seconds", report.seconds)?;
    all.set_item("samples", report.samples)?;
    all.set_item("bounces", report.bounces)?;
    all.set_item("stderr_dc", report.stderr_dc)?;
    Ok(all)
}

/// Transfer that was baked at vertices.
#[pyclass(frozen, module = "lobe")]
pub(crate) struct Transfer(AnyTransfer);

/// The transfer of a baked .glb, or of a .safetensors file.
#[pyfunction]
pub(crate) fn load_transfer(py: Python<'_>, path: PathBuf) -> PyResult<Transfer> {
    let read = answered(py, usize::MAX, move || match has_ending(&path, "safetensors") {
        true => read_any_transfer(&path).map(|(transfer, _)| transfer),
        false => read_baked(&path, &SceneReadOptions::default()).map(|baked| baked.transfer.into()),
    })?;
    read.map(Transfer).map_err(|error| error_of(&error))
}

#[pymethods]
impl Transfer {
    /// The number of bands.
    #[getter]
    fn order(&self) -> usize {
        self.0.order()
    }

    /// The number of receivers.
    fn __len__(&self) -> usize {
        self.0.receivers()
    }

    /// The coefficients, `(receivers, n²)` or `(receivers, 3, n²)`, also of 16 bits; none of compressed transfer.
    fn coefficients<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f32>>>> {
        let of_halves;
        let transfer = match &self.0 {
            AnyTransfer::Plain(transfer) => transfer,
            AnyTransfer::Half(halves) => {
                of_halves = halves.to_transfer();
                &of_halves
            }
            _ => return Ok(None),
        };
        let (rows, bands, channels) = (transfer.receivers(), transfer.order().pow(2), transfer.channels().count());
        let shape = if channels == 1 { vec![rows, bands] } else { vec![rows, channels, bands] };
        array_of(py, transfer.coefficients().to_vec(), &shape).map(Some)
    }

    /// Writes the numbers in their own form as a .safetensors file, of which [`load_transfer`] makes the same. How they were made is not in it.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let recipe = Recipe::default();
        let written = py.detach(|| match &self.0 {
            AnyTransfer::Plain(transfer) => write_transfer(&path, transfer, &recipe, Job::default()),
            AnyTransfer::Half(transfer) => write_half_transfer(&path, transfer, &recipe),
            AnyTransfer::Compressed(transfer) => write_compressed_transfer(&path, transfer, &recipe),
            AnyTransfer::Zonal(transfer) => write_zonal_transfer(&path, transfer, &recipe),
        });
        written.map_err(|error| error_of(&error))
    }

    /// What receivers send under light `(n², 3)`: `(receivers, 3)`.
    fn exit_radiance<'py>(
        &self,
        py: Python<'py>,
        light: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let light: Vec<Rgb<f64>> = contiguous(&light)?.as_chunks::<3>().0.iter().map(|c| Rgb::from(*c)).collect();
        let colors = py.detach(|| with_threads(|| self.0.exit_radiance(&light)));
        let numbers = colors.iter().flat_map(|c| c.to_array()).collect();
        array_of(py, numbers, &[colors.len(), 3])
    }
}
