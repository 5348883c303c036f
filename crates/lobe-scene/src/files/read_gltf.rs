//! glTF 2.0 reader.

use glam::{DMat3, DVec3};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;

use crate::files::gltf::accessor::Accessors;
use crate::files::gltf::files::{self, GltfFile};
use crate::files::gltf::materials;
use crate::files::gltf::nodes::Shown;
use crate::files::gltf::placement::shown_meshes;
use crate::files::source::Source;
use crate::{MeshParts, MeshSource, Scene, SceneError, z_up_from_y_up};

/// Reads one mesh for each instance of a primitive by a node, in Lobe's world.
pub(crate) fn read(bytes: &[u8], source: &mut Source<'_>) -> Result<(Scene, GltfFile), SceneError> {
    let file = files::read(bytes, source)?;
    let (materials, textures) = materials::read(&file, source)?;
    let mut meshes = Vec::new();
    let (all_shown, origin) = shown_meshes(&file, source)?;
    for shown in all_shown {
        let Some(mesh) = file.root.meshes.get(shown.mesh) else {
            let (node, mesh, count) = (shown.node, shown.mesh, file.root.meshes.len());
            return Err(source.invalid(format!("node {node} shows mesh {mesh}, but there are {count}")));
        };
        let name = mesh.name.clone().unwrap_or_else(|| shown.mesh.to_string());
        for (index, primitive) in mesh.primitives.iter().enumerate() {
            let place = MeshSource { node: shown.node, mesh: shown.mesh, primitive: index };
            if let Some(parts) = read_primitive(&file, primitive, &name, place, source)? {
                meshes.extend(source.mesh(place_in_world(parts, &shown))?);
            }
        }
    }
    note_unused(&file, source);
    if meshes.is_empty() {
        return Err(source.no_triangles());
    }
    let scene = Scene::new(meshes, materials, textures).map_err(|error| error.within(source.name))?;
    Ok((scene.moved(z_up_from_y_up(origin.to_array())), file))
}

fn note_unused(file: &GltfFile, source: &mut Source<'_>) {
    let root = &file.root;
    for (is_there, what) in [
        (!root.animations.is_empty(), "animations are not used: the scene stands as its nodes say"),
        (!root.skins.is_empty(), "skins are not used: meshes stand as they were bound"),
        (
            root.extensions_used.iter().any(|name| name == "EXT_mesh_gpu_instancing"),
            "EXT_mesh_gpu_instancing is not used: of instanced meshes only one is shown",
        ),
        (
            root.meshes.iter().flat_map(|mesh| &mesh.primitives).any(|primitive| primitive.targets.is_some()),
            "morph targets are not used: meshes stand as they are without",
        ),
    ] {
        if is_there {
            source.note(what);
        }
    }
}

/// The primitive in its own y-up space; `None` for points and lines.
fn read_primitive(
    file: &GltfFile,
    primitive: &Primitive,
    name: &str,
    place: MeshSource,
    source: &mut Source<'_>,
) -> Result<Option<MeshParts>, SceneError> {
    let accessors = Accessors { file, place: format!("mesh `{name}`, primitive {}", place.primitive) };
    let invalid = |source: &Source<'_>, message: &str| source.invalid(format!("{}: {message}", accessors.place));
    let mode = match primitive.mode {
        Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => mode,
        Checked::Valid(_) => {
            source.note(format!("{} has points or lines and was left out", accessors.place));
            return Ok(None);
        }
        Checked::Invalid => return Err(invalid(source, "is of a mode that glTF does not know")),
    };
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let Some(positions) = attribute(Semantic::Positions) else {
        return Err(invalid(source, "has no POSITION"));
    };
    let vertices = accessors.count(positions, source)?;
    let corners = match primitive.indices {
        Some(indices) => accessors.count(indices, source)?,
        None => vertices,
    };
    source.count(vertices, if mode == Mode::Triangles { corners / 3 } else { corners })?;
    let corners = match primitive.indices {
        Some(indices) => accessors.indices(indices, source)?,
        None => (0..vertices as u32).collect(),
    };
    if mode == Mode::Triangles && !corners.len().is_multiple_of(3) {
        let found = corners.len();
        return Err(invalid(source, &format!("expected three indices for each triangle, found {found}")));
    }
    Ok(Some(MeshParts {
        name: if place.primitive == 0 { name.to_string() } else { format!("{name}.{}", place.primitive) },
        positions: accessors.vectors("POSITION", positions, source)?,
        triangles: triangles(mode, &corners),
        normals: optional(attribute(Semantic::Normals), |index| accessors.vectors("NORMAL", index, source))?,
        uvs: [
            optional(attribute(Semantic::TexCoords(0)), |index| accessors.vectors("TEXCOORD_0", index, source))?,
            optional(attribute(Semantic::TexCoords(1)), |index| accessors.vectors("TEXCOORD_1", index, source))?,
        ],
        colors: optional(attribute(Semantic::Colors(0)), |index| accessors.vectors("COLOR_0", index, source))?,
        material: primitive.material.map(|material| material.value()),
        source: Some(place),
    }))
}

fn optional<I, T>(index: Option<I>, read: impl FnOnce(I) -> Result<Vec<T>, SceneError>) -> Result<Vec<T>, SceneError> {
    index.map_or_else(|| Ok(Vec::new()), read)
}

/// The triangles of a list, a strip, in which every other one is reversed, or a fan.
fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turned = |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            corners.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => match corners {
            [] => Vec::new(),
            [hub, rim @ ..] => rim.windows(2).map(|t| [*hub, t[0], t[1]]).collect(),
        },
        _ => corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}

/// Applies the transform of the instance, and converts the y-up world to Lobe's.
fn place_in_world(mut parts: MeshParts, shown: &Shown) -> MeshParts {
    let world = shown.world_from_mesh;
    let moved = |p: [f32; 3]| z_up_from_y_up(world.transform_point3(DVec3::from(p.map(f64::from))).as_vec3().into());
    parts.positions.iter_mut().for_each(|p| *p = moved(*p));
    let linear = DMat3::from_mat4(world);
    // Transform normals by the cofactors, which exist where the inverse does not.
    let (x, y, z) = (linear.x_axis, linear.y_axis, linear.z_axis);
    let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
    for n in &mut parts.normals {
        let turned = cofactors * DVec3::from(n.map(f64::from));
        *n = z_up_from_y_up(turned.normalize_or_zero().as_vec3().into());
    }
    // A mirror reverses the orientation of triangles.
    if sign < 0.0 {
        parts.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_run_around_the_same_way_as_lists() {
        assert_eq!(triangles(Mode::TriangleStrip, &[0, 1, 2, 3]), [[0, 1, 2], [2, 1, 3]], "strip");
        assert_eq!(triangles(Mode::TriangleFan, &[0, 1, 2, 3]), [[0, 1, 2], [0, 2, 3]], "fan");
        assert_eq!(triangles(Mode::Triangles, &[0, 1, 2, 3, 4, 5]), [[0, 1, 2], [3, 4, 5]], "list");
        assert!(triangles(Mode::TriangleFan, &[]).is_empty(), "an empty fan");
    }
}
