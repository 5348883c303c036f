//! Application-specific vertex attributes of glTF files.

use std::path::Path;

use gltf_json::mesh::Semantic;
use gltf_json::validation::Checked;
use gltf_json::{Index, buffer};
use serde_json::Value;

use crate::files::gltf::accessor::{Accessors, view_bytes};
use crate::files::gltf::files::GltfFile;
use crate::files::gltf::plain;
use crate::files::read_gltf;
use crate::files::source::{Source, folder_of, read_file};
use crate::{MeshSource, Scene, SceneError, SceneReadOptions, SceneReadReport};

/// The application-specific attributes of a glTF file, whose names begin with `_`.
pub struct GltfAttributes {
    name: String,
    file: GltfFile,
    /// Those that the scene was read by: their limits hold here too.
    options: SceneReadOptions,
}

/// Reads a scene from a .gltf or .glb file as [`read_scene`](crate::read_scene), and keeps its attributes.
///
/// # Errors
/// As [`read_scene`](crate::read_scene), and [`SceneError::Invalid`] if the file is no glTF.
pub fn read_scene_and_attributes(
    path: impl AsRef<Path>,
    options: &SceneReadOptions,
) -> Result<(Scene, SceneReadReport, GltfAttributes), SceneError> {
    let path = path.as_ref();
    let (name, bytes) = read_file(path)?;
    read_from(&bytes, Source::new(&name, folder_of(path), options))
}

/// [`read_scene_and_attributes`] from the bytes of a file that references no other; `name` stands in messages.
///
/// # Errors
/// As [`read_scene_and_attributes`], and [`SceneError::Unsupported`] if the bytes reference other files.
pub fn read_scene_and_attributes_bytes(
    bytes: &[u8],
    name: &str,
    options: &SceneReadOptions,
) -> Result<(Scene, SceneReadReport, GltfAttributes), SceneError> {
    read_from(bytes, Source::new(name, None, options))
}

fn read_from(bytes: &[u8], mut source: Source<'_>) -> Result<(Scene, SceneReadReport, GltfAttributes), SceneError> {
    let (name, options) = (source.name.to_owned(), source.options.clone());
    let file = plain::read(bytes, &mut source)?;
    let scene = read_gltf::scene_of(&file, &mut source)?;
    let report = source.into_report(&scene);
    Ok((scene, report, GltfAttributes { name, file, options }))
}

impl GltfAttributes {
    /// The value of `asset.extras`; null without one.
    #[must_use]
    pub fn asset_extras(&self) -> &Value {
        &self.file.json["asset"]["extras"]
    }

    /// The attribute of this name, with `N` floats for each vertex, of the primitive from which a mesh comes; `None`
    /// without one.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] if it does not hold vectors of `N` floats, or its numbers are not in the file.
    pub fn vectors<const N: usize>(&self, at: MeshSource, name: &str) -> Result<Option<Vec<[f32; N]>>, SceneError> {
        let source = Source::new(&self.name, None, &self.options);
        let mesh = self.file.root.meshes.get(at.mesh);
        let Some(primitive) = mesh.and_then(|mesh| mesh.primitives.get(at.primitive)) else {
            let message = format!("mesh {} has no primitive {}", at.mesh, at.primitive);
            return Err(source.invalid(message));
        };
        let semantic = Semantic::Extras(name.trim_start_matches('_').to_string());
        let Some(&index) = primitive.attributes.get(&Checked::Valid(semantic)) else { return Ok(None) };
        let place = format!("mesh {}, primitive {}", at.mesh, at.primitive);
        Accessors { file: &self.file, place }.vectors(name, index, &source).map(Some)
    }

    /// The bytes of a buffer view.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] if there is no such view, or its bytes are not in the file.
    pub fn buffer_view(&self, index: u32) -> Result<&[u8], SceneError> {
        let view: Index<buffer::View> = Index::new(index);
        view_bytes(&self.file, view).map_err(|message| SceneError::invalid(&self.name, message))
    }
}
