//! Moving scenes by name.

use std::path::{Path, PathBuf};

use anyhow::bail;
use lobe::io::Job;
use lobe::motion::{MovingScene, MovingSplitOptions};
use lobe::prt::AdaptiveOptions;
use lobe::render::RenderError;
use lobe::scene::{AnimatedScene, SceneFormat, built_in, is_gltf};

use crate::loading::file_kind::{DESCRIPTION, FileKind};
use crate::loading::limits::{ReadLimits, plain};
use crate::loading::moving_bakes::moving_transfer_options;
use crate::loading::scene_source::{BUILT_IN, has_ending, open_scene};

/// Reads a scene that may move, repeated from its end: a .glb, .gltf or .vrm file with its first animation, a description (.json) as the
/// command `lobe render moving` takes it, another scene, which stands still, or `built-in:NAME`.
///
/// # Errors
/// One line that says what is wrong with the file or the name.
pub fn open_moving(source: &Path, limits: &ReadLimits) -> anyhow::Result<MovingScene> {
    let text = source.to_string_lossy();
    let options = limits.scene();
    let moving = if let Some(name) = text.strip_prefix(BUILT_IN) {
        let Some(animated) = built_in::moving(name) else {
            let known = built_in::MOVING_NAMES.map(|known| format!("{BUILT_IN}{known}")).join(", ");
            bail!("{text}: there is no such moving scene in the program; there are {known}");
        };
        MovingScene::animated(animated, Some(0))?
    } else if has_ending(source, &[DESCRIPTION]) {
        MovingScene::read(source, &options).map_err(plain)?.0
    } else if is_gltf(source) {
        let (animated, _) = AnimatedScene::read(source, &options).map_err(plain)?;
        let animation = (!animated.animations().is_empty()).then_some(0);
        MovingScene::animated(animated, animation)?
    } else if SceneFormat::of_name(source).is_some() {
        MovingScene::animated(AnimatedScene::still(open_scene(source, limits)?.scene), None)?
    } else {
        let name = source.file_name().unwrap_or_default().to_string_lossy();
        let files = SceneFormat::names(|_| true);
        bail!("{name}: not a scene that can move; expected a {files} file or a description, .json");
    };
    Ok(moving.looped(true))
}

/// Splits a scene from a file, so that it has vertices where shadows fall. Those made by formula have them, and a
/// description says itself which meshes there are.
///
/// # Errors
/// As [`MovingScene::split`].
pub(crate) fn split_for_shadows(scene: &mut MovingScene, source: &Path, job: Job<'_>) -> Result<(), RenderError> {
    if is_file(source) && !has_ending(source, &[DESCRIPTION]) {
        let adaptive = AdaptiveOptions::default();
        let bake = moving_transfer_options(adaptive.bake.order);
        let _counts = scene.split(&MovingSplitOptions::default().adaptive(adaptive.bake(bake)), job)?;
    }
    Ok(())
}

/// Whether a source is a file, and not made by formula.
pub(crate) fn is_file(source: &Path) -> bool {
    !source.to_string_lossy().starts_with(BUILT_IN)
}

/// The name of a built-in moving scene as a source.
pub(crate) fn built_in_moving(name: &str) -> PathBuf {
    PathBuf::from(format!("{BUILT_IN}{name}"))
}

/// The same scene with fields and spheres from files, each of the part that it is nearest to.
///
/// # Errors
/// One line that says what is wrong with a file, or that no part is where it is.
pub(crate) fn with_files(scene: MovingScene, files: &[PathBuf]) -> anyhow::Result<MovingScene> {
    let mut scene = scene;
    for file in files {
        let _part = match FileKind::of(file).map_err(anyhow::Error::msg)? {
            FileKind::Field => scene.set_field_from(file)?,
            FileKind::Spheres => scene.set_spheres_from(file)?,
            _ => bail!("{}: expected an occlusion field or spheres", file.display()),
        };
    }
    Ok(scene)
}
