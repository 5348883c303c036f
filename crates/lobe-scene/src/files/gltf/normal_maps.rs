//! Tangents of primitives whose materials have a normal texture: those of the file, or else computed.

use gltf_json::mesh::{Primitive, Semantic};
use gltf_json::validation::Checked;

use crate::error::SceneError;
use crate::files::gltf::accessor::Accessors;
use crate::files::gltf::files::GltfFile;
use crate::files::gltf::primitive::place_of;
use crate::files::source::Source;
use crate::scene::material::NormalMap;
use crate::scene::mesh::{Mesh, MeshParts, MeshSource};

/// Bytes of the tangents of a triangle.
const TRIANGLE: u64 = size_of::<[[f32; 4]; 3]>() as u64;

/// Bytes of a vertex while tangents are computed: 85 to find the first of its kind, which has 37 in a table of up to 16/7 places for
/// each, 4 for the number of that, 48 for its sums.
const VERTEX: u64 = 137;

/// The tangents at the corners of the triangles of a primitive in its own y-up space, as the file gives them. None without
/// normals: glTF says that tangents are ignored then.
pub(crate) fn given_tangents(
    file: &GltfFile,
    primitive: &Primitive,
    parts: &MeshParts,
    at: MeshSource,
    source: &mut Source<'_>,
) -> Result<Vec<[[f32; 4]; 3]>, SceneError> {
    let attribute = primitive.attributes.get(&Checked::Valid(Semantic::Tangents)).copied();
    let Some(index) = attribute.filter(|_| !parts.normals.is_empty()) else { return Ok(Vec::new()) };
    let accessors = Accessors { file, place: place_of(&file.root.meshes[at.mesh], at.mesh, at.primitive) };
    let (found, expected) = (accessors.count(index, source)?, parts.positions.len());
    if found != expected {
        let place = &accessors.place;
        let message = format!("{place}: expected {expected} tangents, one for each vertex, found {found}");
        return Err(source.invalid(message));
    }
    source.count_bytes(TRIANGLE.saturating_mul(parts.triangles.len() as u64))?;
    let tangents: Vec<[f32; 4]> = accessors.vectors("TANGENT", index, source)?;
    // Indices out of range are refused where the mesh is made.
    let corner = |i: u32| tangents.get(i as usize).copied().unwrap_or_default();
    Ok(parts.triangles.iter().map(|t| t.map(corner)).collect())
}

/// A mesh with the tangents that the normal map of its material needs, computed where the file gave none.
pub(crate) fn with_tangents(mesh: Mesh, map: NormalMap, source: &mut Source<'_>) -> Result<Mesh, SceneError> {
    let set = map.used.uv_set;
    if mesh.uvs(set).is_empty() {
        let name = mesh.name();
        source.note(format!(
            "mesh `{name}` has no texture coordinates of set {set} for the normal texture of its material, which is not used there"
        ));
        return Ok(mesh.without_tangents());
    }
    if !mesh.tangents().is_empty() {
        return Ok(mesh);
    }
    source.count_bytes(TRIANGLE.saturating_mul(mesh.triangles().len() as u64))?;
    source.check_bytes(VERTEX.saturating_mul(mesh.positions().len() as u64))?;
    Ok(mesh.with_tangents(set))
}
