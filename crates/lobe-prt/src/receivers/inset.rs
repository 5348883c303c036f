//! Receivers at the borders of meshes, moved a little inwards.

use glam::DVec3;
use lobe_scene::{Mesh, Scene};

use crate::receivers::edges::for_each_edge;

/// The distance that vertices move, as a part of the largest coordinate of the scene: twice the lift of a ray's origin
/// above a surface ([`lobe_scene::Bvh::offset`]), so that halfway between two walls it is clear of both.
const INSET: f64 = 128.0 / 16_777_216.0;

/// but not farther than this part of the way to the middle of the triangles around.
const MOST: f64 = 0.125;

/// The positions of the fronts and of the backs of all vertices of all meshes, those at a border moved into the mesh by
/// 2⁻¹⁷ of the largest coordinate.
///
/// Where a floor ends at a wall its last vertices lie in the wall: what they see depends on rounding, and half of their
/// rays would start behind it. What is wanted of them is what the floor beside them sees. A border is an edge of one
/// triangle only, by the indices of its vertices, so that meshes with a normal for each face have borders at all edges.
///
/// The way goes to the mean of the middles of the triangles around. Where that is below the surface, because the
/// surface is convex, it goes along the plane of the normal instead. What is convex from one side is not from the
/// other: each side goes its own way, because along the plane of a strongly bent surface a back would come out at the
/// front.
pub(crate) fn inset_positions(scene: &Scene) -> [Vec<[f32; 3]>; 2] {
    let distance = inset_distance(scene);
    let [mut fronts, mut backs] = [0; 2].map(|_| Vec::with_capacity(scene.vertex_count()));
    for mesh in scene.meshes() {
        for ((position, normal), way) in mesh.positions().iter().zip(mesh.normals()).zip(ways(mesh)) {
            let (position, normal) = (wide(*position), wide(*normal));
            let moved = |normal: DVec3| step(position, way - normal * way.dot(normal).min(0.0), distance);
            fronts.push(moved(normal));
            backs.push(moved(-normal));
        }
    }
    [fronts, backs]
}

/// The distance that points at a border move.
pub(crate) fn inset_distance(scene: &Scene) -> f64 {
    let bounds = scene.bounds();
    let largest = bounds.min.iter().chain(&bounds.max).fold(0.0, |most: f32, c| most.max(c.abs()));
    INSET * f64::from(largest)
}

/// A point moved along `way` by `distance`, but not far along the way.
pub(crate) fn step(position: DVec3, way: DVec3, distance: f64) -> [f32; 3] {
    (position + way.normalize_or_zero() * distance.min(MOST * way.length())).as_vec3().to_array()
}

/// For each vertex at a border the way to the mean of the middles of the triangles around, for others zero.
fn ways(mesh: &Mesh) -> impl Iterator<Item = DVec3> {
    let is_border = border(mesh);
    let mut ways = vec![(DVec3::ZERO, 0.0); mesh.positions().len()];
    for (t, triangle) in mesh.triangles().iter().enumerate() {
        let [a, b, c] = mesh.corners(t).map(wide);
        for &i in triangle.iter().filter(|&&i| is_border[i as usize]) {
            let way = &mut ways[i as usize];
            way.0 += (a + b + c) / 3.0 - wide(mesh.positions()[i as usize]);
            way.1 += 1.0;
        }
    }
    ways.into_iter().map(|(sum, count)| sum / f64::max(count, 1.0))
}

/// A vector in the precision of ways.
pub(crate) fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

/// Whether each vertex is an end of an edge that one triangle has alone.
pub(crate) fn border(mesh: &Mesh) -> Vec<bool> {
    let sides = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].map(|[a, b]| [a.min(b), a.max(b)]);
    let mut is_border = vec![false; mesh.positions().len()];
    for_each_edge(
        || mesh.triangles().iter().flat_map(sides),
        |[a, b], triangles| {
            if triangles.len() == 1 {
                is_border[a as usize] = true;
                is_border[b as usize] = true;
            }
        },
    );
    is_border
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_scene::{MeshParts, built_in};

    #[test]
    fn vertices_at_a_border_move_inside_and_no_others() {
        let scene = built_in::ball_over_ground(8);
        let ground = scene.meshes()[0].positions().len();
        let ([moved, backs], mut borders) = (inset_positions(&scene), 0);
        assert_eq!(backs, moved, "both sides of what is flat");
        for (p, q) in scene.meshes()[0].positions().iter().zip(&moved[..ground]) {
            let edges = [0, 1].map(|k| p[k].abs() == 4.0);
            borders += usize::from(edges[0] || edges[1]);
            let way = (0..3).map(|k| (p[k] - q[k]).abs()).fold(0.0, f32::max);
            assert!(way <= 4.0 / 131_072.0 && (way > 0.0) == (edges[0] || edges[1]), "{p:?} moved to {q:?}");
            assert!((0..2).all(|k| !edges[k] || q[k].abs() < 4.0 - 1e-5) && q[2] == 0.0, "{p:?} moved to {q:?}");
        }
        assert_eq!(borders, 32, "vertices at the border of 8 x 8 cells");
    }

    #[test]
    fn at_a_convex_border_vertices_do_not_sink_below_the_surface() {
        // Half a pyramid: its tip is at the border, and the middles of its triangles are below.
        let parts = MeshParts {
            positions: vec![[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            normals: vec![[0.0, 0.0, 1.0]; 4],
            ..MeshParts::default()
        };
        let scene = Scene::new(vec![Mesh::new(parts).unwrap()], vec![], vec![]).unwrap();
        let [tip, back] = inset_positions(&scene).map(|side| side[0]);
        assert!(tip[2] == 1.0 && tip[1] > 1e-6 && tip[0].abs() < 1e-9, "the tip moved to {tip:?}");
        // From below the middles are above the plane of the normal.
        assert!(back[2] < 1.0 && back[1] > 1e-6 && back[0].abs() < 1e-9, "the back of the tip moved to {back:?}");
    }

    #[test]
    fn a_border_is_an_edge_that_one_triangle_has_alone() {
        // Against a count of all edges, one by one: of bumps, of three triangles at one edge, and of one without area.
        let fan = MeshParts {
            positions: [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [2.0; 3]]
                .to_vec(),
            triangles: vec![[0, 1, 2], [1, 0, 3], [4, 0, 1], [5, 5, 2]],
            ..MeshParts::default()
        };
        let mut meshes = built_in::columns_hall(4).meshes().to_vec();
        meshes.push(Mesh::new(fan).unwrap());
        for mesh in &meshes {
            let sides = |t: &[u32; 3]| [0, 1, 2].map(|k| [t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3])]);
            let mut counts = std::collections::BTreeMap::new();
            mesh.triangles().iter().flat_map(sides).for_each(|side| *counts.entry(side).or_insert(0) += 1);
            let mut expected = vec![false; mesh.positions().len()];
            let alone = counts.iter().filter(|&(_, &count)| count == 1);
            alone.flat_map(|(side, _)| side).for_each(|&vertex| expected[vertex as usize] = true);
            assert_eq!(border(mesh), expected, "{}", mesh.name());
        }
    }
}
