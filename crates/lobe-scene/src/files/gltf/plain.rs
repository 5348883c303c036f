//! glTF files made plain: what they store compressed or in arrays, or leave to the reader, stands in buffers and nodes.

use std::borrow::Cow;

use crate::error::SceneError;
use crate::files::gltf::files::GltfFile;
#[cfg(feature = "compressed")]
use crate::files::gltf::meshopt;
use crate::files::gltf::{draco, flat, instancing, smooth, unfolded};
use crate::files::source::Source;

/// Reads a file and makes it plain, in the order in which the parts may depend on each other.
pub(crate) fn read(bytes: Cow<'_, [u8]>, source: &mut Source<'_>) -> Result<GltfFile, SceneError> {
    let mut file = GltfFile::read(bytes, source)?;
    #[cfg(feature = "compressed")]
    meshopt::decode(&mut file, source)?;
    #[cfg(not(feature = "compressed"))]
    crate::files::built_without::refuse(&file.json, source)?;
    draco::decode(&mut file, source)?;
    unfolded::count(&file, source)?;
    instancing::expand(&mut file, source)?;
    if source.is_flat(true) {
        flat::split_vertices(&mut file, source)?;
    } else {
        smooth::write_normals(&mut file, source)?;
    }
    Ok(file)
}
