//! Bakes: what a scene does to light, at its vertices.

use std::fs;
use std::path::{Path, PathBuf};

use lobe::io::{Job, Shard, merge_shards};
use lobe::prt::{
    AlbedoMode, AnyTransfer, BakeMode, BakeOptions, BakeReport, BakedGlb, PrtError, Receivers, Recipe,
    bake_matrices_on_disk, bake_matrices_shard, bake_on_disk, bake_shard, read_any_transfer, read_baked,
    write_matrices, write_transfer,
};
use lobe::scene::{Bvh, GltfDocument, Scene, SceneReadOptions, built_in, is_gltf, read_scene, read_scene_and_document};
use lobe::sh::Rgb;
use numpy::{PyArrayDyn, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::job::{error_of, watched};
use crate::rows::{array_of, contiguous, value_error};

/// The prefix of scenes that come with Lobe.
const BUILT_IN: &str = "built-in:";

/// A scene whose light at vertices can be baked, and how.
#[pyclass(frozen, module = "lobe")]
pub(crate) struct Bake {
    name: String,
    scene: Scene,
    document: Option<GltfDocument>,
    options: BakeOptions,
}

fn mode_of(name: &str) -> PyResult<BakeMode> {
    let all = [BakeMode::Unshadowed, BakeMode::Shadowed, BakeMode::Interreflected, BakeMode::Glossy];
    let found = all.into_iter().find(|mode| mode.name() == name);
    found.ok_or_else(|| {
        value_error(format!("mode: expected unshadowed, shadowed, interreflected or glossy, found {name:?}"))
    })
}

/// A scene from a file or from Lobe, and all that a glTF file holds beside it.
pub(crate) fn read(path: &Path) -> Result<(Scene, Option<GltfDocument>), PrtError> {
    let text = path.display().to_string();
    if let Some(name) = text.strip_prefix(BUILT_IN) {
        let scene = built_in::named(name).ok_or_else(|| {
            PrtError::Options(format!("expected one of {}, found {name:?}", built_in::NAMES.join(", ")))
        })?;
        return Ok((scene, None));
    }
    if is_gltf(path) {
        let (scene, _, document) = read_scene_and_document(path, &SceneReadOptions::default())?;
        return Ok((scene, Some(document)));
    }
    Ok((read_scene(path, &SceneReadOptions::default())?.0, None))
}

#[pymethods]
impl Bake {
    /// Reads a scene. What does not fit together is refused by the bake.
    #[new]
    #[expect(clippy::too_many_arguments, reason = "the options of a bake, by name in Python")]
    fn new(
        py: Python<'_>,
        scene: PathBuf,
        mode: &str,
        order: usize,
        samples: u32,
        bounces: usize,
        energy_stop: f64,
        seed: u64,
        demodulated: bool,
    ) -> PyResult<Self> {
        let albedo = if demodulated { AlbedoMode::None } else { AlbedoMode::Vertex };
        let options = BakeOptions::default().mode(mode_of(mode)?).order(order).samples(samples);
        let options = options.bounces(bounces).energy_stop(energy_stop).seed(seed).albedo(albedo);
        let name = scene.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let (scene, document) = py.detach(|| read(&scene)).map_err(|error| error_of(&error))?;
        Ok(Self { name, scene, document, options })
    }

    /// The number of vertices.
    #[getter]
    fn vertices(&self) -> usize {
        self.scene.vertex_count()
    }

    /// Bakes, with results kept beside the output until it is written.
    fn write<'py>(
        &self,
        py: Python<'py>,
        output: PathBuf,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let checkpoint = beside(&output, ".checkpoint");
        let (bvh, receivers) = self.prepare(py)?;
        let progress = progress.as_ref();
        let report = if self.options.mode == BakeMode::Glossy {
            if has_ending(&output, "glb") {
                return Err(value_error("glossy transfer is written as .safetensors"));
            }
            let bake = |job: Job<'_>| bake_matrices_on_disk(&self.scene, &bvh, &receivers, &self.options, job);
            let (matrices, report) = watched(py, progress, Some(&checkpoint), bake)?;
            watched(py, progress, None, |job| write_matrices(&output, &matrices, &self.recipe(&report), job))?;
            report
        } else if has_ending(&output, "glb") {
            let glb = self.glb().map_err(|error| error_of(&error))?;
            let channels = self.options.channels_for(&self.scene, receivers.is_gray());
            glb.check_size(self.options.order, channels).map_err(|error| error_of(&error))?;
            let bake = |job: Job<'_>| bake_on_disk(&self.scene, &bvh, &receivers, &self.options, job);
            let (transfer, report) = watched(py, progress, Some(&checkpoint), bake)?;
            watched(py, progress, None, |job| glb.write(&output, &transfer, &self.recipe(&report), job))?;
            report
        } else if has_ending(&output, "safetensors") {
            let bake = |job: Job<'_>| bake_on_disk(&self.scene, &bvh, &receivers, &self.options, job);
            let (transfer, report) = watched(py, progress, Some(&checkpoint), bake)?;
            watched(py, progress, None, |job| write_transfer(&output, &transfer, &self.recipe(&report), job))?;
            report
        } else {
            let name = output.display();
            return Err(value_error(format!("{name}: expected a name that ends in .glb or .safetensors")));
        };
        // The results are safe; a checkpoint that stays is taken up by the same bake.
        let _ = fs::remove_file(&checkpoint);
        report_of(py, &report)
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
        let shard = Shard::new(number, count)
            .ok_or_else(|| value_error(format!("shard: expected one of {count} from 1 on, found {number}")))?;
        let (bvh, receivers) = self.prepare(py)?;
        let report = watched(py, progress.as_ref(), Some(&output), |job| match self.options.mode {
            BakeMode::Glossy => bake_matrices_shard(&self.scene, &bvh, &receivers, &self.options, shard, job),
            _ => bake_shard(&self.scene, &bvh, &receivers, &self.options, shard, job),
        })?;
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
        let checkpoint = beside(&output, ".checkpoint");
        watched(py, progress.as_ref(), None, |job| merge_shards(&parts, &checkpoint, job))?;
        self.write(py, output, progress).inspect_err(|_| {
            // It is made again in no time, and would be in the way of another bake.
            let _ = fs::remove_file(&checkpoint);
        })
    }
}

impl Bake {
    fn prepare(&self, py: Python<'_>) -> PyResult<(Bvh, Receivers)> {
        let prepared = py.detach(|| Ok((Bvh::new(&self.scene), Receivers::at_vertices(&self.scene)?)));
        prepared.map_err(|error: PrtError| error_of(&error))
    }

    fn glb(&self) -> Result<BakedGlb, PrtError> {
        match &self.document {
            Some(document) => BakedGlb::of_document(document.clone(), &self.scene),
            None => Ok(BakedGlb::of_scene(&self.scene)),
        }
    }

    fn recipe(&self, report: &BakeReport) -> Recipe {
        Recipe::of_bake(&self.scene, &self.options, report).scene(self.name.clone())
    }
}

fn beside(output: &Path, ending: &str) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(ending);
    name.into()
}

fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}

fn report_of<'py>(py: Python<'py>, report: &BakeReport) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("receivers", report.receivers)?;
    all.set_item("rays", report.rays)?;
    all.set_item("seconds", report.seconds)?;
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
    let read = py.detach(|| match has_ending(&path, "safetensors") {
        true => read_any_transfer(&path).map(|(transfer, _)| transfer),
        false => read_baked(&path, &SceneReadOptions::default()).map(|baked| baked.transfer.into()),
    });
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

    /// The coefficients, `(receivers, n²)` or `(receivers, 3, n²)`; none of compressed transfer.
    fn coefficients<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f32>>>> {
        let AnyTransfer::Plain(transfer) = &self.0 else { return Ok(None) };
        let (rows, bands, channels) = (transfer.receivers(), transfer.order().pow(2), transfer.channels().count());
        let shape = if channels == 1 { vec![rows, bands] } else { vec![rows, channels, bands] };
        array_of(py, transfer.coefficients().to_vec(), &shape).map(Some)
    }

    /// What receivers send under light `(n², 3)`: `(receivers, 3)`.
    fn exit_radiance<'py>(
        &self,
        py: Python<'py>,
        light: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let light: Vec<Rgb<f64>> = contiguous(&light)?.as_chunks::<3>().0.iter().map(|c| Rgb::from(*c)).collect();
        let colors = py.detach(|| self.0.exit_radiance(&light));
        let numbers = colors.iter().flat_map(|c| c.to_array()).collect();
        array_of(py, numbers, &[colors.len(), 3])
    }
}
