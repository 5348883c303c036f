//! Occluders and lamps that move, a file each: occlusion fields, sets of spheres, and the light around lamps.

use std::path::PathBuf;

use lobe::io::JobOptions as _;
use lobe::sh::Rgb;
use lobe::shadow::{
    FieldJob, FieldSampling, Lamp, LampSequence, LogTable, LogTableOptions, PatchField, RadianceField, Rectangle,
    ShadowError, SphereJob, SphereSetJson, StorageOptions, write_lamp, write_log_table,
};
use numpy::{PyArrayDyn, PyReadonlyArray3, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::forked::with_threads;
use crate::job::{answered, error_of, watched, watched_and_heard};
use crate::options::{json_of, refusal, values_of};
use crate::outputs::prepare;
use crate::rows::{array_of, contiguous, value_error};

/// The one ending of these files.
const SAFETENSORS: &[&str] = &["safetensors"];

/// Bakes an occlusion field or the visibility of an entity's own surface: all of it, a shard, or what is put together of
/// shards.
#[pyfunction]
pub(crate) fn field<'py>(
    py: Python<'py>,
    asked: &Bound<'py, PyDict>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let job = FieldJob::from_values(values_of(asked)?).map_err(|error| refusal(&error))?;
    let found = watched_and_heard(py, progress.as_ref(), |work| job.run(work))?;
    json_of(py, &found)
}

/// Centers `(k, 3)` and radii `(k)` of spheres, the volume outside the solid, of the union, and of the solid, the first of these after
/// each round, and the part of the space of which it is certain whether it is solid.
type Fitted<'py> = (Bound<'py, PyArrayDyn<f32>>, Bound<'py, PyArrayDyn<f32>>, f64, f64, f64, Vec<f64>, f64);

/// Fits spheres to a scene, or to one entity of it whose joints they then follow; writes them if there is an output.
#[pyfunction]
pub(crate) fn spheres<'py>(
    py: Python<'py>,
    asked: &Bound<'py, PyDict>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Fitted<'py>> {
    let job = SphereJob::from_values(values_of(asked)?).map_err(|error| refusal(&error))?;
    let (spheres, told) = watched_and_heard(py, progress.as_ref(), |work| job.run(work))?;
    let centers = array_of(py, spheres.centers().as_flattened().to_vec(), &[spheres.len(), 3])?;
    let radii = array_of(py, spheres.radii().to_vec(), &[spheres.len()])?;
    let SphereSetJson { outside_volume, union_volume, solid_volume, history, certainty, .. } = told;
    Ok((centers, radii, outside_volume, union_volume, solid_volume, history, certainty))
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

/// The shape of a lamp.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct LampSettings {
    radiance: [f64; 3],
    /// Of a sphere.
    radius: Option<f64>,
    /// Of a rectangle, and what follows.
    size: Option<[f64; 2]>,
    two_sided: bool,
    patches: [usize; 2],
    fps: f64,
}

/// Writes a lamp; of a rectangle with what it shows, pictures `(height, width, 3)` of single precision as seen from behind. Bytes of
/// the numbers.
#[pyfunction]
pub(crate) fn lamp(
    py: Python<'_>,
    output: PathBuf,
    settings: LampSettings,
    tables: (Bound<'_, PyDict>, Bound<'_, PyDict>),
    pictures: Vec<PyReadonlyArray3<'_, f32>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<usize> {
    prepare(&output, SAFETENSORS, &[])?;
    let fault = |error: ShadowError| error_of(&error);
    let sampling = FieldSampling::from_values(values_of(&tables.0)?).map_err(|error| refusal(&error))?;
    let storage = StorageOptions::from_values(values_of(&tables.1)?).map_err(|error| refusal(&error))?;
    let radiance = Rgb::from(settings.radiance);
    let lamp = match (settings.radius, settings.size) {
        (Some(radius), _) => {
            Lamp::Still(RadianceField::ball(sampling.order, [0.0; 3], radius, radiance).map_err(fault)?)
        }
        (None, Some(size)) => {
            let rectangle = Rectangle::upright(size, settings.two_sided);
            let patches = if pictures.is_empty() { [1, 1] } else { settings.patches };
            let field = watched(py, progress.as_ref(), None, |job| {
                PatchField::bake(&rectangle, patches, &sampling.of_lamp(), job)
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
    let stored = py.detach(|| with_threads(|| write_lamp(&output, &lamp, &storage.form()))).map_err(fault)?;
    Ok(stored.bytes)
}

/// The radiance of the patches under a picture.
fn colors(field: &PatchField, picture: &PyReadonlyArray3<'_, f32>, radiance: Rgb<f64>) -> PyResult<Vec<Rgb<f64>>> {
    let pixels: &[Rgb<f32>] = bytemuck::cast_slice(contiguous(picture)?);
    let colors = field.patch_colors(picture.shape()[1], pixels).map_err(|error| error_of(&error))?;
    Ok(colors.into_iter().map(|c| c * radiance).collect())
}
