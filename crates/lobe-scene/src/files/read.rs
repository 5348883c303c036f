//! Scene reader: chooses the format by the extension.

use std::path::Path;

use crate::files::gltf::plain;
use crate::files::read_gltf;
use crate::files::read_obj;
use crate::files::read_ply;
use crate::files::source::{Source, folder_of, read_file};
use crate::{Scene, SceneError, SceneReadOptions, SceneReadReport, Up};

/// Whether a file's name says that it is glTF: .gltf, .glb, or .vrm, a .glb of a character.
#[must_use]
pub fn is_gltf(path: impl AsRef<Path>) -> bool {
    let extension = path.as_ref().extension().unwrap_or_default();
    ["gltf", "glb", "vrm"].iter().any(|known| extension.eq_ignore_ascii_case(known))
}

/// Reads a scene from a .gltf, .glb, .vrm, .obj or .ply file, with the files it references: z up, in the file's unit of
/// length.
///
/// # Errors
/// [`SceneError::Io`] if a file cannot be read, [`SceneError::Unsupported`] if it has another format or requires a
/// feature that Lobe does not read, [`SceneError::Invalid`] if it contradicts itself or holds no triangle with an area,
/// [`SceneError::Refused`] if it expands to more than [`SceneReadOptions::max_triangles`], [`SceneReadOptions::max_texels`] or
/// [`SceneReadOptions::max_bytes`].
pub fn read_scene(path: impl AsRef<Path>, options: &SceneReadOptions) -> Result<(Scene, SceneReadReport), SceneError> {
    let path = path.as_ref();
    let (name, bytes) = read_file(path)?;
    read_scene_from(&bytes, Source::new(&name, folder_of(path), options), options.up)
}

/// Reads a scene from the bytes of a file that references no other; `name` decides the format and stands in messages.
///
/// # Errors
/// As [`read_scene`], and [`SceneError::Unsupported`] if the bytes reference other files.
pub fn read_scene_bytes(
    bytes: &[u8],
    name: &str,
    options: &SceneReadOptions,
) -> Result<(Scene, SceneReadReport), SceneError> {
    read_scene_from(bytes, Source::new(name, None, options), options.up)
}

/// Reads a scene from bytes and the files that they reference.
pub(crate) fn read_scene_from(
    bytes: &[u8],
    source: Source<'_>,
    up: Up,
) -> Result<(Scene, SceneReadReport), SceneError> {
    let mut source = source;
    let extension = Path::new(source.name).extension().map(|e| e.to_string_lossy().to_lowercase());
    let scene = match extension.as_deref() {
        _ if is_gltf(source.name) => {
            let file = plain::read(bytes, &mut source)?;
            read_gltf::scene_of(&file, &mut source)?
        }
        Some("obj") => read_obj::read(bytes, &mut source, up)?,
        Some("ply") => read_ply::read(bytes, &mut source, up)?,
        _ => return Err(source.unsupported("expected a file named .gltf, .glb, .vrm, .obj or .ply")),
    };
    let report = source.into_report(&scene);
    Ok((scene, report))
}
