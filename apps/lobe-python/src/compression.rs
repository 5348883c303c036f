//! Compression of transfer by clustered principal components or to 16 bits, and its fit by zonal lobes: files into files, as the command makes them.

use std::path::{Path, PathBuf};

use lobe::prt::{
    CompressOptions, CompressReport, CompressedTransfer, HalfTransfer, PrtError, Recipe, Transfer, WeightBits,
    ZonalFitOptions, error_curve as curve_of, fit_zonal, read_baked, read_transfer, write_compressed_transfer,
    write_half_transfer, write_zonal_transfer,
};
use lobe::scene::SceneReadOptions;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::job::{answered, error_of, watched};
use crate::outputs::{has_ending, prepare};
use crate::rows::value_error;

/// The options of compression; of a weight the number of bits.
pub(crate) fn compress_options(
    clusters: Option<usize>,
    components: Option<usize>,
    weights: Option<usize>,
) -> PyResult<CompressOptions> {
    let defaults = CompressOptions::default();
    let bits = match weights.unwrap_or(16) {
        8 => WeightBits::U8,
        16 => WeightBits::U16,
        32 => WeightBits::F32,
        other => return Err(value_error(format!("weights: expected 8, 16 or 32 bits, found {other}"))),
    };
    let (clusters, components) = (clusters.unwrap_or(defaults.clusters), components.unwrap_or(defaults.components));
    Ok(defaults.clusters(clusters).components(components).weights(bits))
}

pub(crate) fn report_of_compression<'py>(py: Python<'py>, report: &CompressReport) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("clusters", report.clusters)?;
    all.set_item("components", report.components)?;
    all.set_item("squared_error", report.squared_error)?;
    all.set_item("relative_error", report.relative_error)?;
    all.set_item("bytes_before", report.bytes_before)?;
    all.set_item("bytes", report.bytes)?;
    all.set_item("ratio", report.ratio)?;
    all.set_item("iterations", report.iterations.clone())?;
    Ok(all)
}

/// The transfer of a baked scene, mesh by mesh, or of a .safetensors file, and the recipe of its bake.
fn read(path: &Path) -> Result<(Transfer, Recipe), PrtError> {
    if has_ending(path, "safetensors") {
        return read_transfer(path);
    }
    let baked = read_baked(path, &SceneReadOptions::default())?;
    Ok((baked.transfer, baked.recipe))
}

fn read_answered(py: Python<'_>, path: PathBuf) -> PyResult<(Transfer, Recipe)> {
    answered(py, usize::MAX, move || read(&path))?.map_err(|error| error_of(&error))
}

/// Compresses the transfer of a file.
#[pyfunction]
pub(crate) fn compress<'py>(
    py: Python<'py>,
    input: PathBuf,
    output: PathBuf,
    numbers: (Option<usize>, Option<usize>, Option<usize>),
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    prepare(&output, &["safetensors"], &[&input])?;
    let (clusters, components, weights) = numbers;
    let options = compress_options(clusters, components, weights)?;
    let (transfer, recipe) = read_answered(py, input)?;
    let (compressed, report) =
        watched(py, progress.as_ref(), None, |job| CompressedTransfer::new(&transfer, &options, job))?;
    let recipe = recipe.of_compressed(&options, &report);
    py.detach(|| write_compressed_transfer(&output, &compressed, &recipe)).map_err(|error| error_of(&error))?;
    let all = report_of_compression(py, &report)?;
    all.set_item("receivers", transfer.receivers())?;
    Ok(all)
}

/// Rounds the transfer of a file to 16 bits.
#[pyfunction]
pub(crate) fn compress_f16(py: Python<'_>, input: PathBuf, output: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    prepare(&output, &["safetensors"], &[&input])?;
    let name = input.display().to_string();
    let (transfer, recipe) = read_answered(py, input)?;
    let rounded = py.detach(|| HalfTransfer::new(&transfer));
    let (halves, report) = rounded.map_err(|error| value_error(format!("{name}: {error}")))?;
    py.detach(|| write_half_transfer(&output, &halves, &recipe.of_halves(&report)))
        .map_err(|error| error_of(&error))?;
    let all = PyDict::new(py);
    all.set_item("receivers", transfer.receivers())?;
    all.set_item("relative_error", report.relative_error)?;
    all.set_item("bytes_before", report.bytes_before)?;
    all.set_item("bytes", report.bytes)?;
    all.set_item("ratio", report.ratio)?;
    Ok(all)
}

/// A point of a curve: clusters, components, the squared and the relative error, and bytes with weights of 16 bits.
type Point = (usize, usize, f64, f64, usize);

/// The errors of all pairs of numbers of clusters and components.
#[pyfunction]
pub(crate) fn error_curve(
    py: Python<'_>,
    input: PathBuf,
    clusters: Vec<usize>,
    components: Vec<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<Point>> {
    let (transfer, _) = read_answered(py, input)?;
    let options = compress_options(None, None, None)?;
    let points =
        watched(py, progress.as_ref(), None, |job| curve_of(&transfer, &clusters, &components, &options, job))?;
    let numbers = points.iter().map(|p| (p.clusters, p.components, p.squared_error, p.relative_error, p.bytes));
    Ok(numbers.collect())
}

/// Fits lobes to the transfer of a file.
#[pyfunction]
pub(crate) fn fit_lobes<'py>(
    py: Python<'py>,
    input: PathBuf,
    output: PathBuf,
    lobes: usize,
    closed_form: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    prepare(&output, &["safetensors"], &[&input])?;
    let (transfer, recipe) = read_answered(py, input)?;
    let options = ZonalFitOptions::default().lobes(lobes).optimize(!closed_form);
    let (zonal, report) = watched(py, progress.as_ref(), None, |job| fit_zonal(&transfer, &options, job))?;
    let recipe = recipe
        .lobes(lobes)
        .closed_form(closed_form)
        .relative_error(report.relative_error)
        .fitted_by(env!("CARGO_PKG_VERSION").to_owned());
    py.detach(|| write_zonal_transfer(&output, &zonal, &recipe)).map_err(|error| error_of(&error))?;
    let all = PyDict::new(py);
    all.set_item("receivers", zonal.receivers())?;
    all.set_item("lobes", zonal.lobes())?;
    all.set_item("squared_error", report.squared_error)?;
    all.set_item("relative_error", report.relative_error)?;
    all.set_item("worst_relative_error", report.worst_relative_error)?;
    all.set_item("bytes", zonal.bytes())?;
    Ok(all)
}
