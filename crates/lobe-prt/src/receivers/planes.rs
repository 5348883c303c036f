//! The planes of the triangles that receivers lie on.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use lobe_io::Fingerprint;
use lobe_scene::{Mesh, Scene};

use crate::receivers::inset::{border, wide};
use crate::receivers::vertex_key::vertex_key;

/// The cosine between a normal to shade with and that of a plane above which they are the same but for rounding.
const SAME: f64 = 1.0 - 1e-6;

/// A vertex of more planes than this has each of them once: thousands of triangles at one place are of few.
const MOST_UNSORTED: u32 = 64;

/// For each receiver the unit normals of the triangles around it, on the side of its own normal.
///
/// Where the normal to shade with tilts off a triangle, directions above the one may be below the other. From a point
/// within the triangle they lead into the surface, and bring nothing: paths are cut there, as where they meet a
/// surface later. Of a vertex, a direction below one triangle may be above its neighbor and free, as at a ridge, or meet
/// the first from the side of the second, as in a valley. It leads into the surface if it is below all of them.
///
/// A receiver whose normal is that of one of its triangles has no planes here: no direction is below all of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Planes {
    /// Where each receiver's normals begin and end; none at all if no receiver has any.
    ranges: Vec<[u32; 2]>,
    normals: Vec<[f32; 3]>,
}

impl Planes {
    /// The planes around all vertices of all meshes.
    ///
    /// Vertices of equal position and normal share theirs, because surfaces are cut along seams of texture coordinates.
    pub(crate) fn at_vertices(scene: &Scene) -> Self {
        let numbers = shared_vertices(scene);
        let normals: Vec<[f32; 3]> = scene.meshes().iter().flat_map(Mesh::normals).copied().collect();
        // Count the triangles around each number, but where one has the normal of the vertex.
        const FLAT: u32 = u32::MAX;
        let mut counts = vec![0_u32; numbers.len()];
        for_each_corner(scene, |vertex, plane| {
            let count = &mut counts[numbers[vertex] as usize];
            let is_same = plane.dot(wide(normals[vertex])).abs() > SAME;
            *count = if is_same || *count == FLAT { FLAT } else { *count + 1 };
        });
        // Give each number a range of its own.
        let (mut ranges, mut end) = (vec![[0; 2]; numbers.len()], 0);
        for (range, count) in ranges.iter_mut().zip(&counts).filter(|(_, count)| **count != FLAT) {
            *range = [end; 2];
            end += count;
        }
        // Fill the ranges.
        let mut planes = vec![[0.0; 3]; end as usize];
        for_each_corner(scene, |vertex, plane| {
            let number = numbers[vertex] as usize;
            if counts[number] != FLAT {
                planes[ranges[number][1] as usize] = turned(plane, normals[vertex]);
                ranges[number][1] += 1;
            }
        });
        for range in ranges.iter_mut().filter(|[begin, end]| end - begin > MOST_UNSORTED) {
            range[1] = range[0] + distinct(&mut planes[range[0] as usize..range[1] as usize]);
        }
        Self { ranges: numbers.iter().map(|&number| ranges[number as usize]).collect(), normals: planes }
    }

    /// Room for receivers on one triangle each.
    pub(crate) fn with_capacity(receivers: usize) -> Self {
        Self { ranges: Vec::with_capacity(receivers), normals: Vec::with_capacity(receivers) }
    }

    /// Adds a receiver with this normal on one triangle, whose lit side is that of `vertex_normal`. The normal itself may, by a
    /// normal map, point below the triangle.
    pub(crate) fn push(&mut self, normal: [f32; 3], vertex_normal: [f32; 3], plane: [f32; 3]) {
        let begin = self.normals.len() as u32;
        self.normals.extend(plane_of_point(normal, vertex_normal, plane));
        self.ranges.push([begin, self.normals.len() as u32]);
    }

    /// The normals of a receiver's planes.
    pub(crate) fn of(&self, receiver: usize) -> &[[f32; 3]] {
        self.ranges.get(receiver).map_or(&[], |&[begin, end]| &self.normals[begin as usize..end as usize])
    }

    /// The planes of some receivers, seen from their own side for a factor of 1, from the other one for -1.
    pub(crate) fn select(&self, which: &[usize], factor: f32) -> Self {
        let mut planes = Self::default();
        for &receiver in which {
            let begin = planes.normals.len() as u32;
            planes.normals.extend(self.of(receiver).iter().map(|n| n.map(|c| factor * c)));
            planes.ranges.push([begin, planes.normals.len() as u32]);
        }
        planes
    }

    /// Writes all of them into a fingerprint.
    pub(crate) fn write_into(&self, fingerprint: &mut Fingerprint) {
        fingerprint.words(self.ranges.as_flattened().iter().map(|&place| u64::from(place)));
        fingerprint.floats(self.normals.as_flattened());
    }
}

/// The plane of the triangle that a point with this normal lies on, on the lit side, which is that of `vertex_normal`;
/// none if the two normals are the same.
pub(crate) fn plane_of_point(normal: [f32; 3], vertex_normal: [f32; 3], plane: [f32; 3]) -> Option<[f32; 3]> {
    let plane = turned(wide(plane), vertex_normal);
    (wide(plane).dot(wide(normal)) <= SAME).then_some(plane)
}

/// For each vertex of all meshes the first one with its position and normal. Only those at borders are compared:
/// others have all their triangles.
pub(crate) fn shared_vertices(scene: &Scene) -> Vec<u32> {
    let mut shared: HashMap<[[u32; 3]; 2], u32> = HashMap::new();
    let mut numbers = Vec::with_capacity(scene.vertex_count());
    for mesh in scene.meshes() {
        for (is_border, (position, normal)) in border(mesh).iter().zip(mesh.positions().iter().zip(mesh.normals())) {
            let (key, own) = ([*position, *normal].map(vertex_key), numbers.len() as u32);
            numbers.push(if *is_border { *shared.entry(key).or_insert(own) } else { own });
        }
    }
    numbers
}

/// Calls `found` for each corner of each triangle, with its vertex among those of all meshes and the unit normal.
fn for_each_corner(scene: &Scene, mut found: impl FnMut(usize, DVec3)) {
    let mut first = 0;
    for mesh in scene.meshes() {
        for (t, triangle) in mesh.triangles().iter().enumerate() {
            let [a, b, c] = mesh.corners(t).map(wide);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            triangle.iter().for_each(|&i| found(first + i as usize, normal));
        }
        first += mesh.positions().len();
    }
}

/// Sorts normals and moves those that are there several times behind the others; returns how many are not.
fn distinct(normals: &mut [[f32; 3]]) -> u32 {
    normals.sort_unstable_by_key(|&normal| vertex_key(normal));
    let mut count = 0;
    for k in 0..normals.len() {
        if count == 0 || normals[k] != normals[count - 1] {
            normals.swap(count, k);
            count += 1;
        }
    }
    count as u32
}

/// The normal of a plane on the side of another normal: triangles that run round the other way have the same plane.
fn turned(plane: DVec3, normal: [f32; 3]) -> [f32; 3] {
    (if plane.dot(wide(normal)) < 0.0 { -plane } else { plane }).as_vec3().to_array()
}

/// Whether a direction is below all of these planes, if there are any.
pub(crate) fn is_below(planes: &[[f32; 3]], direction: [f32; 3]) -> bool {
    let is_above = |n: &[f32; 3]| Vec3::from(*n).dot(Vec3::from(direction)) > 0.0;
    !planes.is_empty() && !planes.iter().any(is_above)
}

#[cfg(test)]
mod tests {
    use lobe_scene::MeshParts;

    use super::*;

    /// Two triangles that meet in a ridge, each a mesh of its own, the second with `zero` for the x of the ridge.
    fn roof(zero: f32) -> Scene {
        let side = |x: f32, zero: f32| MeshParts {
            positions: vec![[zero, 0.0, 1.0], [zero, 1.0, 1.0], [x, 0.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            ..MeshParts::default()
        };
        let meshes = [side(1.0, 0.0), side(-1.0, zero)].map(|parts| Mesh::new(parts).unwrap());
        Scene::new(meshes.to_vec(), vec![], vec![]).unwrap()
    }

    #[test]
    fn vertices_at_zero_and_minus_zero_share_their_planes() {
        let planes = [0.0, -0.0].map(|zero| Planes::at_vertices(&roof(zero)));
        assert_eq!(planes[1], planes[0], "with -0 and with 0");
        assert_eq!(planes[0].of(0).len(), 2, "planes at the ridge: {:?}", planes[0]);
    }
}
