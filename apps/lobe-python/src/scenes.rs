//! Scenes as inputs: files, with how they are read, and the scenes of Lobe.

use std::path::PathBuf;

use lobe::io::{JobOptions as _, MemoryLimit};
use lobe::prt::{OpenScene, PrtError};
use lobe::scene::{Bvh, Scene, SceneSource};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::job::heard;
use crate::options::{refusal, values_of};

/// Where a scene is, and how it is read: a path, or a `lobe.Scene`.
#[derive(Clone)]
pub(crate) struct SceneInput {
    pub(crate) source: SceneSource,
    pub(crate) memory: MemoryLimit,
}

impl<'a, 'py> FromPyObject<'a, 'py> for SceneInput {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(path) = given.extract::<PathBuf>() {
            return Ok(Self { source: SceneSource::of(path), memory: MemoryLimit::of_bytes(None) });
        }
        let refused = |_| PyTypeError::new_err("scene: expected the path of a file or a lobe.Scene");
        let asked = given.call_method0("_asked").and_then(|asked| Ok(asked.cast_into::<PyDict>()?)).map_err(refused)?;
        let source = SceneSource::from_values(values_of(&asked)?).map_err(|error| refusal(&error))?;
        Ok(Self { source, memory: MemoryLimit::of_bytes(given.getattr("max_bytes")?.extract()?) })
    }
}

/// Refuses options of reading that are out of range, or that a scene has no use for.
#[pyfunction]
pub(crate) fn check_scene(asked: &Bound<'_, PyDict>) -> PyResult<()> {
    SceneSource::from_values(values_of(asked)?).map(drop).map_err(|error| refusal(&error))
}

impl SceneInput {
    pub(crate) fn open(self) -> Result<OpenScene, PrtError> {
        OpenScene::new(self.source, self.memory.bytes())
    }

    /// The scene as it stands at the time that is asked for, with its tree.
    pub(crate) fn read(self, py: Python<'_>) -> PyResult<(Scene, Bvh)> {
        heard(py, move |work| {
            let scene = self.open()?.scene(work)?;
            let bvh = Bvh::new(&scene);
            Ok::<_, PrtError>((scene, bvh))
        })
    }
}
