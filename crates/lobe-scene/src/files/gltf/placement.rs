//! The origin of a glTF scene that is far from that of its world.

use std::collections::HashMap;

use glam::DVec3;
use gltf_json::mesh::Semantic;
use gltf_json::validation::Checked;

use crate::error::SceneError;
use crate::files::gltf::accessor::Accessors;
use crate::files::gltf::files::GltfFile;
use crate::files::gltf::nodes::{Origin, Shown, walk};
use crate::files::gltf::primitive::is_of_triangles;
use crate::files::source::Source;
use crate::scene::near_origin::{far_center, reach};

/// The instances of a file's meshes with transforms that count from an origin near them, and that origin.
pub(crate) fn shown_meshes(file: &GltfFile, source: &Source<'_>) -> Result<(Vec<Shown>, DVec3), SceneError> {
    let origin = origin_of(file, source)?;
    Ok((walk(&file.root, &origin, source)?.shown, origin.point))
}

/// The point from which transforms are to count: the origin of the world, unless the scene is far from it.
///
/// Then it is the place of the first node in its neighborhood, the node that moved it there: the scene comes out as it does
/// without that node, bit by bit, unless it is far from the origin even then. If there is none, it is the center of the scene.
pub(crate) fn origin_of(file: &GltfFile, source: &Source<'_>) -> Result<Origin, SceneError> {
    let found = walk(&file.root, &Origin::default(), source)?;
    let Some([min, max]) = bounds(file, &found.shown, source) else { return Ok(Origin::default()) };
    let (min, max) = (min.to_array(), max.to_array());
    let center = DVec3::from(far_center(min, max));
    if center == DVec3::ZERO {
        return Ok(Origin::default());
    }
    let is_far = center.cmpne(DVec3::ZERO);
    let is_near = |place: &DVec3| !((*place - center).abs().cmpgt(DVec3::splat(reach(min, max))) & is_far).any();
    let node = found.places.iter().find(|(_, place)| is_near(place));
    let place = node.map_or(center.as_vec3().as_dvec3(), |&(_, place)| place);
    Ok(Origin { point: DVec3::select(is_far, place, DVec3::ZERO), node: node.map(|&(index, _)| index) })
}

/// The smallest and largest coordinates of boxes around all meshes shown; none if there are no numbers. Faults of the
/// file are left to its reading.
fn bounds(file: &GltfFile, shown: &[Shown], source: &Source<'_>) -> Option<[DVec3; 2]> {
    let mut of_mesh: HashMap<usize, Option<[DVec3; 2]>> = HashMap::new();
    let mut all: Option<[DVec3; 2]> = None;
    for Shown { mesh, world_from_mesh, .. } in shown {
        let own = *of_mesh.entry(*mesh).or_insert_with(|| bounds_of_mesh(file, *mesh, source));
        let Some(own) = own else { continue };
        for corner in 0..8 {
            let at = |k: usize| own[corner >> k & 1][k];
            grow(&mut all, world_from_mesh.transform_point3(DVec3::new(at(0), at(1), at(2))));
        }
    }
    all.filter(|[min, max]| min.is_finite() && max.is_finite())
}

fn bounds_of_mesh(file: &GltfFile, mesh: usize, source: &Source<'_>) -> Option<[DVec3; 2]> {
    let mut all = None;
    for primitive in &file.root.meshes.get(mesh)?.primitives {
        let Some(&index) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) else { continue };
        // Points and lines are not shown, nor counted.
        if is_of_triangles(primitive).is_none() {
            continue;
        }
        let accessors = Accessors { file, place: String::new() };
        let positions: Vec<[f32; 3]> = accessors.vectors("POSITION", index, source).unwrap_or_default();
        positions.iter().for_each(|p| grow(&mut all, DVec3::from(p.map(f64::from))));
    }
    all
}

/// Makes a box large enough for a point.
fn grow(bounds: &mut Option<[DVec3; 2]>, p: DVec3) {
    let [min, max] = bounds.get_or_insert([p; 2]);
    (*min, *max) = (min.min(p), max.max(p));
}
