//! Moving scenes by name.

use std::path::{Path, PathBuf};

use anyhow::bail;
use lobe::render::MovingScene;
use lobe::scene::{AnimatedScene, built_in, is_gltf};

use crate::loading::limits;
use crate::loading::scene_source::{BUILT_IN, ENDINGS, has_ending, open_scene};

/// The ending of descriptions of scenes.
pub(crate) const DESCRIPTION: &str = "json";

/// Reads a scene that may move, repeated from its end: a .glb, .gltf or .vrm file with its first animation, a description (.json) as the
/// command `lobe render --mode fields` takes it, another scene, which stands still, or `built-in:NAME`.
///
/// # Errors
/// One line that says what is wrong with the file or the name.
pub fn open_moving(source: &Path) -> anyhow::Result<MovingScene> {
    let text = source.to_string_lossy();
    let options = limits::of_scenes();
    let moving = if let Some(name) = text.strip_prefix(BUILT_IN) {
        let Some(animated) = built_in::moving(name) else {
            let known = built_in::MOVING_NAMES.map(|known| format!("{BUILT_IN}{known}")).join(", ");
            bail!("{text}: there is no such moving scene in the program; there are {known}");
        };
        MovingScene::animated(animated, Some(0))?
    } else if has_ending(source, &[DESCRIPTION]) {
        MovingScene::read(source, &options).map_err(limits::in_flags)?.0
    } else if is_gltf(source) {
        let (animated, _) = AnimatedScene::read(source, &options).map_err(limits::in_flags)?;
        let animation = (!animated.animations().is_empty()).then_some(0);
        MovingScene::animated(animated, animation)?
    } else if has_ending(source, &ENDINGS) {
        MovingScene::animated(AnimatedScene::still(open_scene(source)?.scene), None)?
    } else {
        let name = source.file_name().unwrap_or_default().to_string_lossy();
        bail!("{name}: not a scene that can move; there are .glb, .gltf, .vrm, .obj, .ply and descriptions, .json");
    };
    Ok(moving.looped(true))
}

/// Whether a source is a file, and not made by formula.
pub(crate) fn is_file(source: &Path) -> bool {
    !source.to_string_lossy().starts_with(BUILT_IN)
}

/// The name of a built-in moving scene as a source.
pub(crate) fn built_in_moving(name: &str) -> PathBuf {
    PathBuf::from(format!("{BUILT_IN}{name}"))
}
