//! Occluders and lamps that move, a file each: occlusion fields, sets of spheres, and the light around lamps.

use std::fs;
use std::path::{Path, PathBuf};

use lobe::io::Job;
use lobe::prt::PrtError;
use lobe::scene::{AnimatedScene, Entity, Scene};
use lobe::sh::Rgb;
use lobe::shadow::{
    FieldOptions, FieldReport, FieldStorage, Lamp, LampSequence, LogTable, LogTableOptions, PatchField, RadianceField,
    RadianceOptions, Rectangle, ShadowError, SphereFitMethod, SphereFitOptions, StorageReport, SurfaceVisibility,
    VisibilityOptions, bake_field, bake_field_shard, bake_vertex_visibility, fit_spheres, write_field, write_lamp,
    write_log_table, write_spheres, write_visibility,
};
use numpy::{PyArrayDyn, PyReadonlyArray3, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::forked::with_threads;
use crate::job::{answered, error_of, watched};
use crate::outputs::{beside, prepare};
use crate::rows::{array_of, contiguous, value_error};
use crate::scenes::{Read, SceneInput};
use crate::sharing::{merge, of_merged, shard_of};

/// The one ending of these files.
const SAFETENSORS: &[&str] = &["safetensors"];

/// The options of a field, whose ranges the package has checked.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct FieldSettings {
    /// Of the scene this one alone, in its own frame.
    entity: Option<String>,
    order: usize,
    spheres: usize,
    cells: usize,
    range: [f64; 2],
    rays: u32,
    seed: u64,
    storage: String,
}

impl FieldSettings {
    fn options(&self) -> FieldOptions {
        let [inner, outer] = self.range;
        let options = FieldOptions::default().order(self.order).spheres(self.spheres).cells(self.cells);
        options.inner(inner).outer(outer).rays(self.rays).seed(self.seed)
    }

    fn storage(&self) -> PyResult<FieldStorage> {
        storage_of(&self.storage)
    }
}

/// How numbers are stored.
fn storage_of(name: &str) -> PyResult<FieldStorage> {
    match name {
        "f32" => Ok(FieldStorage::F32),
        "f16" => Ok(FieldStorage::F16),
        "u8" => Ok(FieldStorage::U8),
        "clustered" => Ok(FieldStorage::Clustered(FieldStorage::clustered())),
        other => Err(value_error(format!("storage: expected f32, f16, u8 or clustered, found {other:?}"))),
    }
}

/// Bakes the occlusion field of a scene, with results kept beside the output until it is written, or takes them from all of its shards.
#[pyfunction]
pub(crate) fn field<'py>(
    py: Python<'py>,
    scene: SceneInput,
    output: PathBuf,
    settings: FieldSettings,
    parts: Vec<PathBuf>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let inputs: Vec<&Path> = parts.iter().chain([&scene.path]).map(PathBuf::as_path).collect();
    prepare(&output, SAFETENSORS, &inputs)?;
    let (options, storage) = (settings.options(), settings.storage()?);
    let scene = read(py, scene, settings.entity)?;
    let progress = progress.as_ref();
    let bake = |checkpoint: &Path| watched(py, progress, Some(checkpoint), |job| bake_field(&scene, &options, job));
    let (checkpoint, baked) = if parts.is_empty() {
        let checkpoint = beside(&output, ".checkpoint");
        let baked = bake(&checkpoint);
        (checkpoint, baked)
    } else {
        // Beside what a bake that was stopped may have kept.
        let checkpoint = beside(&output, ".merged.checkpoint");
        merge(py, &parts, &checkpoint, progress)?;
        let baked = bake(&checkpoint).map_err(|error| of_merged(py, error, &parts, &checkpoint));
        (checkpoint, baked)
    };
    let (field, report) = baked?;
    let stored =
        py.detach(|| with_threads(|| write_field(&output, &field, &storage))).map_err(|error| error_of(&error))?;
    // The results are safe; a checkpoint that stays is taken up by the same bake.
    let _ = fs::remove_file(&checkpoint);
    let FieldReport { points, inside, rays, .. } = report;
    let all = report_of(py, &stored)?;
    all.set_item("points", points)?;
    all.set_item("inside", inside)?;
    all.set_item("rays", rays)?;
    Ok(all)
}

/// Bakes a shard of the occlusion field, which is the file that it is kept in: its sample points, and those in all.
#[pyfunction]
pub(crate) fn field_shard(
    py: Python<'_>,
    scene: SceneInput,
    output: PathBuf,
    settings: FieldSettings,
    shard: (u32, u32),
    progress: Option<Py<PyAny>>,
) -> PyResult<[usize; 2]> {
    let shard = shard_of(shard.0, shard.1)?;
    prepare(&output, SAFETENSORS, &[&scene.path])?;
    let (options, scene) = (settings.options(), read(py, scene, settings.entity)?);
    watched(py, progress.as_ref(), Some(&output), |job| bake_field_shard(&scene, &options, shard, job))
}

/// Writes what each vertex sees of the sky past the scene itself, with results kept beside the output until it is written.
#[pyfunction]
pub(crate) fn self_visibility<'py>(
    py: Python<'py>,
    scene: SceneInput,
    output: PathBuf,
    settings: FieldSettings,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    prepare(&output, SAFETENSORS, &[&scene.path])?;
    let storage = settings.storage()?;
    let options = VisibilityOptions::default().order(settings.order).rays(settings.rays).seed(settings.seed);
    let scene = read(py, scene, settings.entity)?;
    let checkpoint = beside(&output, ".checkpoint");
    let (rows, rays) =
        watched(py, progress.as_ref(), Some(&checkpoint), |job| bake_vertex_visibility(&scene, &options, job))?;
    let stored = py.detach(|| {
        let positions = scene.meshes().iter().flat_map(lobe::scene::Mesh::positions).copied().collect();
        let visibility = SurfaceVisibility::new(settings.order, rows)?.with_positions(positions)?;
        with_threads(|| write_visibility(&output, &visibility, &storage))
    });
    let stored = stored.map_err(|error: ShadowError| error_of(&error))?;
    let _ = fs::remove_file(&checkpoint);
    let all = report_of(py, &stored)?;
    all.set_item("vertices", scene.vertex_count())?;
    all.set_item("rays", rays)?;
    Ok(all)
}

/// A scene, or one entity of it.
fn read(py: Python<'_>, scene: SceneInput, entity: Option<String>) -> PyResult<Scene> {
    let read = answered(py, usize::MAX, move || whole_or_entity(&scene, entity.as_deref()))?;
    let (scene, _) = read.map_err(|error| error_of(&error))?.told(py)?;
    Ok(scene)
}

fn report_of<'py>(py: Python<'py>, stored: &StorageReport) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("bytes", stored.bytes)?;
    all.set_item("bytes_before", stored.bytes_before)?;
    all.set_item("relative_error", stored.relative_error)?;
    all.set_item("largest_error", stored.largest_error)?;
    Ok(all)
}

/// The options of a fit of spheres, whose ranges the package has checked.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct SphereSettings {
    count: usize,
    method: String,
    points: usize,
    rounds: usize,
    seed: u64,
}

/// Centers `(k, 3)` and radii `(k)` of spheres, the volume outside the solid, of the union, and of the solid, the first of these after
/// each round, and the part of the space of which it is certain whether it is solid.
type Fitted<'py> = (Bound<'py, PyArrayDyn<f32>>, Bound<'py, PyArrayDyn<f32>>, f64, f64, f64, Vec<f64>, f64);

/// Fits spheres to a scene, or to one entity of it whose joints they then follow; writes them if there is an output, beside which results are kept
/// while they are found.
#[pyfunction]
pub(crate) fn spheres<'py>(
    py: Python<'py>,
    scene: SceneInput,
    entity: Option<String>,
    output: Option<PathBuf>,
    settings: SphereSettings,
    progress: Option<Py<PyAny>>,
) -> PyResult<Fitted<'py>> {
    let (method, is_kept) = match &*settings.method {
        "variational" => (SphereFitMethod::Variational, true),
        "medial-axis" => (SphereFitMethod::MedialAxis, false),
        other => return Err(value_error(format!("method: expected variational or medial-axis, found {other:?}"))),
    };
    if let Some(output) = &output {
        prepare(output, SAFETENSORS, &[&scene.path])?;
    }
    let place = scene.path.display().to_string();
    let options = SphereFitOptions::default().count(settings.count).method(method).samples(settings.points);
    let options = options.rounds(settings.rounds).seed(settings.seed);
    let found = answered(py, usize::MAX, move || whole_or_entity(&scene, entity.as_deref()))?;
    let found = found.map_err(|error| error_of(&error))?.told(py)?;
    let (whole, entity) = &found;
    // Spheres shrink with what morph targets stretch.
    let widest = entity.as_ref().map(|(animated, entity)| {
        animated.widest_weights(entity).and_then(|weights| animated.morphed_scene(entity, &weights))
    });
    let widest = widest.transpose().map_err(|error| error_of(&error))?;
    let solid = widest.as_ref().unwrap_or(whole);
    let checkpoint = output.as_ref().filter(|_| is_kept).map(|output| beside(output, ".checkpoint"));
    let fit = |mut job: Job<'_>| {
        // What cannot be fitted is the mesh.
        let fitted = fit_spheres(solid, &options, job.reborrow()).map_err(|error| match error {
            ShadowError::Options(message) => ShadowError::Invalid { place, message },
            other => other,
        });
        let (spheres, report) = fitted?;
        match entity {
            Some((animated, entity)) => Ok((spheres.bind_to(animated, entity, &mut job)?, report)),
            None => Ok::<_, ShadowError>((spheres, report)),
        }
    };
    let (spheres, report) = watched(py, progress.as_ref(), checkpoint.as_deref(), fit)?;
    if let Some(output) = &output {
        py.detach(|| write_spheres(output, &spheres)).map_err(|error| error_of(&error))?;
    }
    if let Some(checkpoint) = &checkpoint {
        let _ = fs::remove_file(checkpoint);
    }
    let centers = array_of(py, spheres.centers().as_flattened().to_vec(), &[spheres.len(), 3])?;
    let radii = array_of(py, spheres.radii().to_vec(), &[spheres.len()])?;
    let union = py.detach(|| spheres.union_volume());
    Ok((centers, radii, report.outside_volume, union, report.solid_volume, report.history, report.certainty))
}

/// A scene, or one entity of it with what moves it.
type Solid = (Scene, Option<(AnimatedScene, Entity)>);

/// A scene, or one entity of it in the shape that its skin was bound to.
fn whole_or_entity(input: &SceneInput, entity: Option<&str>) -> Result<Read<Solid>, PrtError> {
    let Some(name) = entity else { return Ok(input.scene()?.map(|scene| (scene, None))) };
    let Read { found: (animated, _), remarks } = input.animated()?;
    let entity = animated.entity(name)?.clone();
    let own = animated.own_scene(&entity)?;
    Ok(Read { found: (own, Some((animated, entity))), remarks })
}

/// Writes the table of what single spheres hide; the number of its rows.
#[pyfunction]
pub(crate) fn sphere_table(
    py: Python<'_>,
    output: PathBuf,
    order: usize,
    window: Option<f64>,
    clamp: f64,
) -> PyResult<usize> {
    prepare(&output, SAFETENSORS, &[])?;
    let mut options = LogTableOptions::default().order(order).clamp(clamp);
    options.window = window;
    let table = answered(py, usize::MAX, move || LogTable::new(&options))?.map_err(|error| error_of(&error))?;
    py.detach(|| write_log_table(&output, &table)).map_err(|error| error_of(&error))?;
    Ok(table.row_count())
}

/// The shape and the options of a lamp, whose ranges the package has checked.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct LampSettings {
    order: usize,
    radiance: [f64; 3],
    storage: String,
    /// Of a sphere.
    radius: Option<f64>,
    /// Of a rectangle, and what follows.
    size: Option<[f64; 2]>,
    two_sided: bool,
    patches: [usize; 2],
    fps: f64,
    spheres: usize,
    cells: usize,
    range: [f64; 2],
}

impl LampSettings {
    fn options(&self) -> RadianceOptions {
        let [inner, outer] = self.range;
        let options = RadianceOptions::default().order(self.order).spheres(self.spheres).cells(self.cells);
        options.inner(inner).outer(outer)
    }
}

/// Writes a lamp; of a rectangle with what it shows, pictures `(height, width, 3)` of single precision as seen from behind. Bytes of
/// the numbers.
#[pyfunction]
pub(crate) fn lamp(
    py: Python<'_>,
    output: PathBuf,
    settings: LampSettings,
    pictures: Vec<PyReadonlyArray3<'_, f32>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<usize> {
    prepare(&output, SAFETENSORS, &[])?;
    let fault = |error: ShadowError| error_of(&error);
    let radiance = Rgb::from(settings.radiance);
    let lamp = match (settings.radius, settings.size) {
        (Some(radius), _) => {
            Lamp::Still(RadianceField::ball(settings.order, [0.0; 3], radius, radiance).map_err(fault)?)
        }
        (None, Some(size)) => {
            let rectangle = Rectangle::upright(size, settings.two_sided);
            let patches = if pictures.is_empty() { [1, 1] } else { settings.patches };
            let field = watched(py, progress.as_ref(), None, |job| {
                PatchField::bake(&rectangle, patches, &settings.options(), job)
            })?;
            let shown =
                pictures.iter().map(|picture| colors(&field, picture, radiance)).collect::<PyResult<Vec<_>>>()?;
            let still = |colors: &[Rgb<f64>]| field.with_colors(colors).map(Lamp::Still).map_err(fault);
            match &*shown {
                [] => still(&[radiance])?,
                [one] => still(one)?,
                _ => {
                    let narrow = |c: Rgb<f64>| Rgb::from(c.to_array().map(|c| c as f32));
                    let shown = shown.into_iter().map(|colors| colors.into_iter().map(narrow).collect()).collect();
                    Lamp::Sequence(LampSequence::new(field, shown, settings.fps).map_err(fault)?)
                }
            }
        }
        (None, None) => return Err(value_error("lamp: expected a radius or a size")),
    };
    let storage = storage_of(&settings.storage)?;
    let stored = py.detach(|| with_threads(|| write_lamp(&output, &lamp, &storage))).map_err(fault)?;
    Ok(stored.bytes)
}

/// The radiance of the patches under a picture.
fn colors(field: &PatchField, picture: &PyReadonlyArray3<'_, f32>, radiance: Rgb<f64>) -> PyResult<Vec<Rgb<f64>>> {
    let pixels: &[Rgb<f32>] = bytemuck::cast_slice(contiguous(picture)?);
    let colors = field.patch_colors(picture.shape()[1], pixels).map_err(|error| error_of(&error))?;
    Ok(colors.into_iter().map(|c| c * radiance).collect())
}
