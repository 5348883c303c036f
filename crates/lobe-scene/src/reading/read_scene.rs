//! Scene reader: chooses the format by the extension.

use std::borrow::Cow;
use std::path::Path;

use crate::error::SceneError;
use crate::files::gltf::plain;
use crate::files::read_options::{SceneReadOptions, SceneReadReport};
use crate::files::scene_format::{is_gltf, read_still};
use crate::files::source::{Source, read_file};
use crate::reading::posed;
use crate::scene::scene::Scene;

/// Reads a scene from a .gltf, .glb, .vrm, .obj or .ply file, with the files it references: z up, in the file's unit of
/// length. A glTF file stands as [`SceneReadOptions::pose`] says.
///
/// # Errors
/// [`SceneError::Io`] if a file cannot be read, [`SceneError::Unsupported`] if it has another format or requires a
/// feature that Lobe does not read, [`SceneError::Invalid`] if it contradicts itself or holds no triangle with an area,
/// [`SceneError::Options`] if the pose names an animation that is not there,
/// [`SceneError::Refused`] if it expands to more than [`SceneReadOptions::max_triangles`],
/// [`SceneReadOptions::max_texels`] or [`SceneReadOptions::max_bytes`].
pub fn read_scene(path: impl AsRef<Path>, options: &SceneReadOptions) -> Result<(Scene, SceneReadReport), SceneError> {
    let path = path.as_ref();
    let (name, bytes) = read_file(path, options)?;
    let source = Source::of_file(&name, path, &bytes, options)?;
    read(bytes.into(), source, options)
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
    read(bytes.into(), Source::new(name, None, options), options)
}

fn read(
    bytes: Cow<'_, [u8]>,
    mut source: Source<'_>,
    options: &SceneReadOptions,
) -> Result<(Scene, SceneReadReport), SceneError> {
    let scene = if is_gltf(source.name) {
        posed::scene_of(&plain::read(bytes, &mut source)?, &options.pose, &mut source)?
    } else {
        read_still(&bytes, options.up, &mut source)?
    };
    let report = source.into_report(&scene);
    Ok((scene, report))
}
