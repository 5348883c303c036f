//! Primitives without normals that are to be smooth: their normals are written down, so that whoever reads a file that is made of this one
//! finds the same.

use serde_json::json;

use crate::error::SceneError;
use crate::files::gltf::files::{GltfFile, push};
use crate::files::gltf::flat::{times_shown, without_normals};
use crate::files::source::Source;
use crate::scene::vertex_normals::angle_weighted_normals;

/// Gives primitives without normals those of [`angle_weighted_normals`] in the mesh's own frame.
pub(crate) fn write_normals(file: &mut GltfFile, source: &mut Source<'_>) -> Result<(), SceneError> {
    let mut made = 0;
    for (mesh, _) in times_shown(file, source)?.into_iter().enumerate().filter(|&(_, times)| times > 0) {
        for primitive in 0..file.root.meshes[mesh].primitives.len() {
            // Those of a morphed mesh are made of each pose.
            if file.root.meshes[mesh].primitives[primitive].targets.as_ref().is_some_and(|targets| !targets.is_empty())
            {
                continue;
            }
            let Some((positions, triangles)) = without_normals(file, [mesh, primitive], source)? else { continue };
            source.count_bytes(size_of_val(positions.as_slice()) as u64)?;
            let normals = angle_weighted_normals(&positions, &triangles);
            let bytes: Vec<u8> = normals.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
            let view = file.push_elements(&bytes, size_of::<[f32; 3]>());
            let accessor = json!({"bufferView": view, "componentType": 5126, "count": normals.len(), "type": "VEC3"});
            let index = push(&mut file.json, "accessors", accessor);
            file.json["meshes"][mesh]["primitives"][primitive]["attributes"]["NORMAL"] = json!(index);
            made += normals.len();
        }
    }
    if made > 0 {
        source.note(format!("normals missing: {made}, made smooth from the triangles, and kept in what is written"));
        file.update(source)?;
    }
    Ok(())
}
