//! Bakes: what a scene does to light, at its vertices, its texels or points in space.

use std::path::{Path, PathBuf};

use lobe::io::{Job, JobFiles, JobOptions as _};
use lobe::prt::{
    AdaptiveReport, AnyTransfer, BakeDone, BakeJob, OpenBake, PreparedBake, Recipe, read_any_transfer, read_baked,
    scene_hash, write_compressed_transfer, write_half_transfer, write_transfer, write_zonal_transfer,
};
use lobe::scene::SceneReadOptions;
use lobe::sh::Rgb;
use numpy::{PyArrayDyn, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::compression::report_of_compression;
use crate::forked::with_threads;
use crate::job::{answered, error_of, heard, watched};
use crate::options::{refusal, values_of};
use crate::outputs::has_ending;
use crate::rows::{array_of, contiguous};
use crate::sharing::shard_of;

/// A bake whose scene is read and split, for shards of it.
#[pyclass(frozen, module = "lobe")]
pub(crate) struct Bake(PreparedBake);

/// The job of a dictionary of options.
fn job_of(asked: &Bound<'_, PyDict>) -> PyResult<BakeJob> {
    BakeJob::from_values(values_of(asked)?).map_err(|error| refusal(&error))
}

/// Refuses options that are out of range, or cannot be had together.
#[pyfunction]
pub(crate) fn check_bake(asked: &Bound<'_, PyDict>) -> PyResult<()> {
    job_of(asked).map(drop)
}

/// Whether triangles are split where transfer is off.
#[pyfunction]
pub(crate) fn is_bake_split(asked: &Bound<'_, PyDict>) -> PyResult<bool> {
    Ok(job_of(asked)?.is_split())
}

/// The options of the bake that made a file.
#[pyfunction]
pub(crate) fn bake_like(py: Python<'_>, path: PathBuf) -> PyResult<Vec<(String, String)>> {
    let job = answered(py, usize::MAX, move || BakeJob::like(&path))?.map_err(|error| error_of(&error))?;
    Ok(job.values().into_iter().map(|(name, value)| (name, value.to_string())).collect())
}

/// Reads the scene of a job.
fn open(py: Python<'_>, job: BakeJob) -> PyResult<OpenBake> {
    heard(py, move |work| OpenBake::read(job, work.reborrow()))
}

/// Bakes and writes the output: all of it, a shard, or what is put together of shards.
#[pyfunction]
pub(crate) fn bake<'py>(
    py: Python<'py>,
    asked: &Bound<'py, PyDict>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let job = job_of(asked)?;
    py.detach(|| job.begin()).map_err(|error| error_of(&error))?;
    let open = open(py, job)?;
    report_of(py, &watched(py, progress.as_ref(), None, |work| open.run(work))?)
}

#[pymethods]
impl Bake {
    /// Reads a scene, and splits it.
    #[new]
    fn new(py: Python<'_>, asked: &Bound<'_, PyDict>) -> PyResult<Self> {
        let open = open(py, job_of(asked)?)?;
        watched(py, None, None, |work| open.prepared(None, work)).map(Self)
    }

    /// The fingerprint of all of the scene that decides the results, 32 hexadecimal digits.
    #[getter]
    fn scene_hash(&self, py: Python<'_>) -> String {
        py.detach(|| scene_hash(self.0.work().scene()))
    }

    /// The number of points: vertices, texels that are seen, or points in space.
    #[getter]
    fn points(&self) -> usize {
        self.0.work().points()
    }

    /// Bytes of all results.
    #[getter]
    fn bytes(&self) -> u64 {
        self.0.work().bytes()
    }

    /// Refuses the name of a file that cannot hold the results, and that of the scene, which would be lost.
    fn check_output(&self, py: Python<'_>, output: PathBuf) -> PyResult<()> {
        let (job, files) = (self.0.job().clone().output(Some(output.clone())), JobFiles::of_merge(output));
        job.check().map_err(|error| refusal(&error))?;
        py.detach(|| job.expect_writable(&files)).map_err(|error| error_of(&error))
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
        report_of(py, &watched(py, progress.as_ref(), None, |work| self.0.write_shard(shard, &output, work))?)
    }

    /// Puts shards together and writes the output: the bytes that one machine alone gives it.
    fn merge<'py>(
        &self,
        py: Python<'py>,
        parts: Vec<PathBuf>,
        output: PathBuf,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let files = JobFiles::of_merge(output);
        let inputs: Vec<&Path> = parts.iter().chain([&self.0.job().source.scene]).map(PathBuf::as_path).collect();
        files.expect_writable(inputs).map_err(|error| error_of(&error))?;
        report_of(py, &watched(py, progress.as_ref(), None, |work| self.0.merge(&parts, &files, work))?)
    }
}

fn report_of<'py>(py: Python<'py>, done: &BakeDone) -> PyResult<Bound<'py, PyDict>> {
    let (all, report) = (PyDict::new(py), &done.report);
    all.set_item("receivers", report.receivers)?;
    all.set_item("rays", report.rays)?;
    all.set_item("seconds", report.seconds)?;
    all.set_item("samples", report.samples)?;
    all.set_item("bounces", report.bounces)?;
    all.set_item("stderr_dc", report.stderr_dc)?;
    if let Some(split) = &done.split {
        all.set_item("adaptive", report_of_split(py, split)?)?;
    }
    if let Some(saved) = &done.compression {
        all.set_item("compression", report_of_compression(py, saved)?)?;
    }
    Ok(all)
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
