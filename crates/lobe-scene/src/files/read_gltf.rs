//! glTF 2.0 reader.

use glam::{DMat3, DVec3};
use gltf_json::mesh::{Primitive, Semantic};
use gltf_json::validation::Checked;

use crate::error::SceneError;
use crate::files::gltf::accessor::Accessors;
use crate::files::gltf::files::GltfFile;
use crate::files::gltf::materials;
use crate::files::gltf::nodes::Shown;
use crate::files::gltf::normal_maps::{given_tangents, with_tangents};
use crate::files::gltf::placement::shown_meshes;
use crate::files::gltf::primitive::{corners_of, is_of_triangles, name_of, place_of, triangles};
use crate::files::read_options::DefaultMaterial;
use crate::files::source::Source;
use crate::scene::material::Material;
use crate::scene::mesh::double_area;
use crate::scene::mesh::{MeshParts, MeshSource};
use crate::scene::scene::Scene;
use crate::scene::transform::Affine;
use crate::scene::up::z_up_from_y_up;

/// What becomes of triangles that have no area as the nodes stand.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flattened {
    /// They are dropped.
    Dropped,
    /// They stay if they can have an area elsewhere: in the space of the mesh, or with other morph targets.
    Kept,
}

/// One mesh for each instance of a primitive by a node, in Lobe's world, as the nodes stand, with normal maps if they
/// are to be read.
pub(crate) fn standing_scene_of(
    file: &GltfFile,
    flattened: Flattened,
    reads_normal_maps: bool,
    source: &mut Source<'_>,
) -> Result<Scene, SceneError> {
    let (all_shown, origin) = shown_meshes(file, source)?;
    let used = used_materials(file, &all_shown);
    let (mut materials, textures) = materials::read(file, &used, reads_normal_maps, source)?;
    let (mut meshes, mut needs_default) = (Vec::new(), false);
    for shown in all_shown {
        let Some(mesh) = file.root.meshes.get(shown.mesh) else {
            let (node, mesh, count) = (shown.node, shown.mesh, file.root.meshes.len());
            return Err(source.invalid(format!("node {node} shows mesh {mesh}, but there are {count}")));
        };
        let name = name_of(mesh, shown.mesh);
        for (index, primitive) in mesh.primitives.iter().enumerate() {
            let place = MeshSource { node: shown.node, mesh: shown.mesh, primitive: index };
            if let Some(mut parts) = read_primitive(file, primitive, &name, place, source)? {
                let normal_map = parts.material.and_then(|index| materials.get(index)?.normal_map);
                if normal_map.is_some() {
                    parts.tangents = given_tangents(file, primitive, &parts, place, source)?;
                }
                if parts.material.is_none() && source.default_material() == DefaultMaterial::AsFormat {
                    parts.material = Some(file.root.materials.len());
                    needs_default = true;
                }
                // Where nothing is flattened, the mesh in its own space is not needed.
                let own =
                    (flattened == Flattened::Kept && flattens(&shown, primitive)).then(|| parts.positions.clone());
                let can_open = |t| own.as_ref().is_some_and(|own| can_open(primitive, own, t));
                let made = source.mesh_keeping(place_in_world(parts, &shown), can_open)?;
                meshes.extend(match (made, normal_map) {
                    (Some(mesh), Some(map)) => Some(with_tangents(mesh, map, source)?),
                    (made, _) => made,
                });
            }
        }
    }
    if needs_default {
        materials.push(Material { name: "default".into(), metallic: 1.0, double_sided: false, ..Material::WHITE });
    }
    if meshes.is_empty() {
        return Err(source.no_triangles());
    }
    let scene = Scene::new(meshes, materials, textures).map_err(|error| error.within(source.name))?;
    Ok(scene.moved(z_up_from_y_up(origin.to_array())))
}

/// Whether each material of the file is that of triangles that are shown.
fn used_materials(file: &GltfFile, all_shown: &[Shown]) -> Vec<bool> {
    let mut is_used = vec![false; file.root.materials.len()];
    let mut is_shown = vec![false; file.root.meshes.len()];
    for shown in all_shown {
        if let Some(is_shown) = is_shown.get_mut(shown.mesh) {
            *is_shown = true;
        }
    }
    let meshes = file.root.meshes.iter().zip(is_shown).filter(|&(_, is_shown)| is_shown);
    let primitives = meshes.flat_map(|(mesh, _)| &mesh.primitives);
    for material in primitives.filter(|primitive| is_of_triangles(primitive).is_some()).filter_map(|p| p.material) {
        if let Some(is_used) = is_used.get_mut(material.value()) {
            *is_used = true;
        }
    }
    is_used
}

/// Whether an instance of a primitive may have triangles without area that have one elsewhere.
fn flattens(shown: &Shown, primitive: &Primitive) -> bool {
    DMat3::from_mat4(shown.world_from_mesh).determinant() == 0.0 || primitive.targets.is_some()
}

/// Whether a triangle has an area in the space of its mesh, or may have one with morph targets.
fn can_open(primitive: &Primitive, own: &[[f32; 3]], [a, b, c]: [u32; 3]) -> bool {
    let corner = |i: u32| own.get(i as usize).copied().unwrap_or_default();
    let is_morphed = || primitive.targets.iter().flatten().any(|target| target.positions.is_some());
    double_area([a, b, c].map(corner)) > 0.0 || (a != b && b != c && c != a && is_morphed())
}

/// The primitive in its own y-up space; `None` for points and lines. It was counted when the file was made plain.
fn read_primitive(
    file: &GltfFile,
    primitive: &Primitive,
    name: &str,
    place: MeshSource,
    source: &mut Source<'_>,
) -> Result<Option<MeshParts>, SceneError> {
    let accessors = Accessors { file, place: place_of(&file.root.meshes[place.mesh], place.mesh, place.primitive) };
    let invalid = |source: &Source<'_>, message: &str| source.invalid(format!("{}: {message}", accessors.place));
    if primitive.mode == Checked::Invalid {
        return Err(invalid(source, "is of a mode that glTF does not know"));
    }
    let Some(mode) = is_of_triangles(primitive) else {
        source.note(format!("{} has points or lines and was left out", accessors.place));
        return Ok(None);
    };
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let Some(positions) = attribute(Semantic::Positions) else {
        return Err(invalid(source, "has no POSITION"));
    };
    let corners = corners_of(&accessors, primitive, positions, source)?;
    Ok(Some(MeshParts {
        name: if place.primitive == 0 { name.to_string() } else { format!("{name}.{}", place.primitive) },
        positions: accessors.vectors("POSITION", positions, source)?,
        triangles: triangles(mode, &corners),
        normals: optional(attribute(Semantic::Normals), |index| accessors.vectors("NORMAL", index, source))?,
        tangents: Vec::new(),
        uvs: [
            optional(attribute(Semantic::TexCoords(0)), |index| accessors.vectors("TEXCOORD_0", index, source))?,
            optional(attribute(Semantic::TexCoords(1)), |index| accessors.vectors("TEXCOORD_1", index, source))?,
        ],
        lightmap_uvs: optional(attribute(Semantic::TexCoords(2)), |index| {
            accessors.vectors("TEXCOORD_2", index, source)
        })?,
        colors: optional(attribute(Semantic::Colors(0)), |index| accessors.vectors("COLOR_0", index, source))?,
        material: primitive.material.map(|material| material.value()),
        source: Some(place),
        halved: Vec::new(),
    }))
}

fn optional<I, T>(index: Option<I>, read: impl FnOnce(I) -> Result<Vec<T>, SceneError>) -> Result<Vec<T>, SceneError> {
    index.map_or_else(|| Ok(Vec::new()), read)
}

/// Applies the transform of the instance, and converts the y-up world to Lobe's.
fn place_in_world(mut parts: MeshParts, shown: &Shown) -> MeshParts {
    let world = Affine::new(shown.world_from_mesh);
    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    parts.positions.iter_mut().for_each(|p| *p = z_up_from_y_up(world.point(vector(*p)).as_vec3().into()));
    parts.normals.iter_mut().for_each(|n| *n = z_up_from_y_up(world.normal(vector(*n)).as_vec3().into()));
    parts.map_tangents(|t| z_up_from_y_up(world.tangent(vector(t)).as_vec3().into()));
    if world.is_mirror() {
        parts.flip();
    }
    parts
}
