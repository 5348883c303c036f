//! The format of a scene's file, by its extension.

use std::path::Path;

use crate::error::SceneError;
use crate::files::source::Source;
use crate::files::{read_obj, read_ply};
use crate::scene::scene::Scene;
use crate::scene::up::Up;

/// Whether a file's name says that it is glTF: .gltf, .glb, or .vrm, a .glb of a character.
#[must_use]
pub fn is_gltf(path: impl AsRef<Path>) -> bool {
    let extension = path.as_ref().extension().unwrap_or_default();
    ["gltf", "glb", "vrm"].iter().any(|known| extension.eq_ignore_ascii_case(known))
}

/// Reads a scene of a format in which nothing moves: of an .obj or a .ply file.
pub(crate) fn read_still(bytes: &[u8], up: Up, source: &mut Source<'_>) -> Result<Scene, SceneError> {
    let extension = Path::new(source.name).extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("obj") => read_obj::read(bytes, source, up),
        Some("ply") => read_ply::read(bytes, source, up),
        _ => Err(source.unsupported("expected a file named .gltf, .glb, .vrm, .obj or .ply")),
    }
}
