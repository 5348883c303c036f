//! Scenes as inputs: files, with how they are read, and the scenes of Lobe.

use std::path::{Path, PathBuf};

use lobe::io::{JobOptions as _, worded};
use lobe::prt::{PrtError, is_baked};
use lobe::scene::{
    AnimatedScene, BUILT_IN, GltfReader, Scene, SceneReadOptions, SceneReadReport, SceneSource, built_in, is_gltf,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::options::{named, refusal, values_of, warn};

/// The path of a scene, and how it is read: a path, or a `lobe.Scene`.
#[derive(Clone)]
pub(crate) struct SceneInput {
    source: SceneSource,
    pub(crate) path: PathBuf,
    pub(crate) options: SceneReadOptions,
}

impl SceneInput {
    fn new(source: SceneSource, max_bytes: Option<u64>) -> Self {
        let options = source.read_options(max_bytes.unwrap_or(u64::MAX));
        Self { path: source.scene.clone(), options, source }
    }
}

impl<'a, 'py> FromPyObject<'a, 'py> for SceneInput {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(path) = given.extract::<PathBuf>() {
            return Ok(Self::new(SceneSource::of(path), None));
        }
        let refused = |_| PyTypeError::new_err("scene: expected the path of a file or a lobe.Scene");
        let asked = given.call_method0("_asked").and_then(|asked| Ok(asked.cast_into::<PyDict>()?)).map_err(refused)?;
        let source = SceneSource::from_values(values_of(&asked)?).map_err(|error| refusal(&error))?;
        Ok(Self::new(source, given.getattr("max_bytes")?.extract()?))
    }
}

/// Refuses options of reading that are out of range, or that a scene has no use for.
#[pyfunction]
pub(crate) fn check_scene(asked: &Bound<'_, PyDict>) -> PyResult<()> {
    SceneSource::from_values(values_of(asked)?).map(drop).map_err(|error| refusal(&error))
}

/// What was read, and what a user should know of it.
pub(crate) struct Read<T> {
    pub(crate) found: T,
    pub(crate) remarks: Vec<String>,
}

impl<T> Read<T> {
    pub(crate) fn silent(found: T) -> Self {
        Self { found, remarks: Vec::new() }
    }

    pub(crate) fn map<U>(self, to: impl FnOnce(T) -> U) -> Read<U> {
        Read { found: to(self.found), remarks: self.remarks }
    }

    /// What was read, with a warning for each remark.
    pub(crate) fn told(self, py: Python<'_>) -> PyResult<T> {
        warn(py, &self.remarks)?;
        Ok(self.found)
    }
}

/// A remark on a file.
pub(crate) fn remark(path: &Path, text: &str) -> String {
    format!("{}: {text}", path.display())
}

impl SceneInput {
    pub(crate) fn is_built_in(&self) -> bool {
        self.path.to_string_lossy().starts_with(BUILT_IN)
    }

    pub(crate) fn with_remarks<T>(&self, found: T, report: &SceneReadReport) -> Read<T> {
        Read { found, remarks: report.remarks().iter().map(|text| remark(&self.path, text)).collect() }
    }

    /// The scene as it stands at the time that is asked for.
    pub(crate) fn scene(&self) -> Result<Read<Scene>, PrtError> {
        let read = self.source.read(self.options.max_bytes, false)?;
        let told = |text: &String| remark(&self.path, &worded(text, named));
        Ok(Read { remarks: read.remarks.iter().map(told).collect(), found: read.scene })
    }

    /// A glTF file, which is not one that is baked where light is asked to go straight through.
    pub(crate) fn gltf(&self) -> Result<GltfReader, PrtError> {
        let gltf = GltfReader::open(&self.path, &self.options)?;
        if self.options.straight_through && is_baked(&gltf) {
            let place = self.path.display();
            let text = format!("transparency: {place} is baked, with or without; bake its scene with the option");
            return Err(PrtError::Options(text));
        }
        Ok(gltf)
    }

    /// A scene with what moves it, and the open file if it is of a glTF file.
    pub(crate) fn animated(&self) -> Result<Read<(AnimatedScene, Option<GltfReader>)>, PrtError> {
        let name = self.path.display().to_string();
        if let Some(made) = name.strip_prefix(BUILT_IN).and_then(built_in::moving) {
            return Ok(Read::silent((made, None)));
        }
        if !is_gltf(&self.path) {
            return Ok(self.scene()?.map(|scene| (AnimatedScene::still(scene), None)));
        }
        let gltf = self.gltf()?;
        let (animated, report) = AnimatedScene::from_gltf(&gltf)?;
        Ok(self.with_remarks((animated, Some(gltf)), &report))
    }
}
