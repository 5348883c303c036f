//! Scenes as inputs: files, with how they are read, and the scenes of Lobe.

use std::ffi::CString;
use std::path::{Path, PathBuf};

use lobe::prt::{PrtError, is_baked};
use lobe::scene::{
    AnimatedScene, DefaultMaterial, GltfDocument, GltfReader, MissingNormals, Scene, ScenePose, SceneReadOptions,
    SceneReadReport, Up, built_in, is_gltf, read_scene,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::rows::value_error;

/// The prefix of scenes that come with Lobe.
pub(crate) const BUILT_IN: &str = "built-in:";

/// The path of a scene, and how it is read: a path, or a `lobe.Scene`, whose options the package has checked.
#[derive(Clone)]
pub(crate) struct SceneInput {
    pub(crate) path: PathBuf,
    pub(crate) options: SceneReadOptions,
}

/// The attributes of a `lobe.Scene`.
#[derive(FromPyObject)]
struct Asked {
    path: PathBuf,
    up: String,
    missing_normals: Option<String>,
    default_material: String,
    allow_outside: bool,
    transparency: bool,
    time: Option<f64>,
    animation: Option<String>,
    max_triangles: Option<usize>,
    max_texels: Option<usize>,
    max_bytes: Option<u64>,
}

impl<'a, 'py> FromPyObject<'a, 'py> for SceneInput {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(path) = given.extract::<PathBuf>() {
            return Ok(Self { path, options: SceneReadOptions::default() });
        }
        let asked: Asked =
            given.extract().map_err(|_| PyTypeError::new_err("scene: expected the path of a file or a lobe.Scene"))?;
        asked.try_into()
    }
}

impl TryFrom<Asked> for SceneInput {
    type Error = PyErr;

    fn try_from(asked: Asked) -> PyResult<Self> {
        let defaults = SceneReadOptions::default();
        let (triangles, texels, bytes) = (defaults.max_triangles, defaults.max_texels, defaults.max_bytes);
        let mut options = defaults
            .allow_outside(asked.allow_outside)
            .straight_through(asked.transparency)
            .pose(ScenePose::asked(asked.animation, asked.time))
            .max_triangles(asked.max_triangles.unwrap_or(triangles))
            .max_texels(asked.max_texels.unwrap_or(texels))
            .max_bytes(asked.max_bytes.unwrap_or(bytes));
        options.up = if asked.up == "z" { Up::Z } else { Up::Y };
        options.missing_normals = match asked.missing_normals.as_deref() {
            None => MissingNormals::AsFormat,
            Some("flat") => MissingNormals::Flat,
            Some("smooth") => MissingNormals::Smooth,
            Some(other) => {
                return Err(value_error(format!("missing_normals: expected flat or smooth, found {other:?}")));
            }
        };
        if asked.default_material == "gltf" {
            options.default_material = DefaultMaterial::AsFormat;
        }
        Ok(Self { path: asked.path, options })
    }
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
        if self.remarks.is_empty() {
            return Ok(self.found);
        }
        let category = py.import("lobe._env")?.getattr("LoadNote")?;
        for text in &self.remarks {
            let text = CString::new(lobe::io::one_line(text)).unwrap_or_default();
            PyErr::warn(py, &category, &text, 2)?;
        }
        Ok(self.found)
    }
}

/// A remark on a file.
pub(crate) fn remark(path: &Path, text: &str) -> String {
    format!("{}: {text}", path.display())
}

/// A scene, all that its glTF file holds beside it, and its pose if the file poses it.
pub(crate) type WithDocument = (Scene, Option<GltfDocument>, Option<ScenePose>);

impl SceneInput {
    pub(crate) fn is_built_in(&self) -> bool {
        self.path.to_string_lossy().starts_with(BUILT_IN)
    }

    pub(crate) fn with_remarks<T>(&self, found: T, report: &SceneReadReport) -> Read<T> {
        Read { found, remarks: report.remarks().iter().map(|text| remark(&self.path, text)).collect() }
    }

    /// The scene, and all that a glTF file holds beside it, with the pose of the scene if the file poses it.
    pub(crate) fn with_document(&self) -> Result<Read<WithDocument>, PrtError> {
        let text = self.path.display().to_string();
        if let Some(name) = text.strip_prefix(BUILT_IN) {
            let scene = built_in::named(name).ok_or_else(|| {
                PrtError::Options(format!("expected one of {}, found {name:?}", built_in::NAMES.join(", ")))
            })?;
            return Ok(Read::silent((scene, None, None)));
        }
        if is_gltf(&self.path) {
            let gltf = GltfReader::open(&self.path, &self.options)?;
            let pose = gltf.has_poses().then(|| self.options.pose.clone());
            let (scene, report, document) = gltf.into_scene_and_document()?;
            return Ok(self.with_remarks((scene, Some(document), pose), &report));
        }
        let (scene, report) = read_scene(&self.path, &self.options)?;
        Ok(self.with_remarks((scene, None, None), &report))
    }

    /// The scene as it stands at the time that is asked for.
    pub(crate) fn scene(&self) -> Result<Read<Scene>, PrtError> {
        Ok(self.with_document()?.map(|(scene, ..)| scene))
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
