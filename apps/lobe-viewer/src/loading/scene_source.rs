//! Scenes by name.

use std::path::{Path, PathBuf};

use anyhow::bail;
use lobe::prt::{Baked, BakedOrScene, read_baked_or_scene, read_baked_or_scene_bytes};
use lobe::scene::{Scene, built_in, is_gltf, read_scene, read_scene_bytes};

use crate::loading::limits::{ReadLimits, plain};
use crate::loading::place::given;
use lobe::render::Surfaces;

/// The prefix of the names of built-in scenes, as of the command `lobe`.
pub(crate) const BUILT_IN: &str = "built-in:";

/// The scene that the window opens with.
pub(crate) const FIRST: &str = "built-in:still-life";

/// A scene, with the transfer that its file carries, if any.
#[derive(Debug)]
#[non_exhaustive]
pub struct OpenedScene {
    /// The name for people: the file without its folders, or that of a built-in scene.
    pub name: String,
    /// The scene.
    pub scene: Scene,
    /// What a baked file holds beside it.
    pub baked: Option<Box<Baked>>,
    /// Whether it is made by formula.
    pub is_built_in: bool,
}

impl OpenedScene {
    /// A scene that is made by formula.
    pub(crate) fn of_built_in(name: &str, scene: Scene) -> Self {
        Self { name: name.into(), scene, baked: None, is_built_in: true }
    }
}

/// Reads a scene: a file of a [`SceneFormat`](lobe::scene::SceneFormat), or `built-in:NAME`.
///
/// # Errors
/// One line that says what is wrong with the file or the name.
pub fn open_scene(source: &Path, limits: &ReadLimits) -> anyhow::Result<OpenedScene> {
    open_scene_for(source, limits, Surfaces::Matte)
}

/// The same with the textures that such surfaces need.
pub(crate) fn open_scene_for(source: &Path, limits: &ReadLimits, surfaces: Surfaces) -> anyhow::Result<OpenedScene> {
    let text = source.to_string_lossy();
    if let Some(name) = text.strip_prefix(BUILT_IN) {
        let Some(scene) = built_in::named(name) else {
            let known = built_in::NAMES.map(|known| format!("{BUILT_IN}{known}")).join(", ");
            bail!("{text}: there is no such scene in the program; there are {known}");
        };
        return Ok(OpenedScene::of_built_in(name, scene));
    }
    let name = source.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let options = limits.scene().finish(surfaces != Surfaces::Matte);
    let is_gltf = is_gltf(source);
    let read: BakedOrScene = match (given(source), is_gltf) {
        (Some(bytes), true) => read_baked_or_scene_bytes(&bytes, &name, &options).map_err(plain)?,
        (Some(bytes), false) => read_scene_bytes(&bytes, &name, &options).map_err(plain)?.0.into(),
        (None, true) => read_baked_or_scene(source, &options).map_err(plain)?,
        (None, false) => read_scene(source, &options).map_err(plain)?.0.into(),
    };
    Ok(match read {
        BakedOrScene::Baked(baked) => {
            OpenedScene { name, scene: baked.scene.clone(), baked: Some(baked), is_built_in: false }
        }
        BakedOrScene::Scene(scene, _) => OpenedScene { name, scene, baked: None, is_built_in: false },
    })
}

/// Whether the path has one of these endings, in any case.
pub(crate) fn has_ending(path: &Path, endings: &[&str]) -> bool {
    let found = path.extension().unwrap_or_default();
    endings.iter().any(|ending| found.eq_ignore_ascii_case(ending))
}

/// Whether a source is a scene that is made by formula.
pub(crate) fn is_built_in(source: &Path) -> bool {
    source.to_string_lossy().starts_with(BUILT_IN)
}

/// The name of a built-in scene as a source.
pub(crate) fn built_in_source(name: &str) -> PathBuf {
    PathBuf::from(format!("{BUILT_IN}{name}"))
}
