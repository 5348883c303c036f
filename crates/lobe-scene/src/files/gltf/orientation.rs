//! Orientation of split triangles: whether they run around as those of the file do, which a mirror turns around.

use std::collections::{BTreeMap, HashMap};

use crate::scene::mesh::Mesh;

/// Whether the triangles of a split mesh run around the other way than those that they are parts of; `None` if one is
/// part of none.
///
/// A vertex is a mean of the first vertices, which are those of the file. The weights of the three corners are a
/// matrix, and its determinant is the part's share of the area, with the sign of its orientation. Triangles that the
/// file has both ways around say nothing. Where no others are, neither way is the wrong one.
pub(crate) fn is_turned(own: &[[u32; 3]], split: &Mesh) -> Option<bool> {
    let mut ways: HashMap<[u32; 3], [bool; 2]> = HashMap::with_capacity(own.len());
    for &triangle in own {
        let (key, is_odd) = sorted(triangle);
        ways.entry(key).or_default()[usize::from(is_odd)] = true;
    }
    for &triangle in split.triangles() {
        let (key, determinant) = part_of(triangle, split)?;
        let [even, odd] = *ways.get(&key)?;
        if even != odd {
            return Some((determinant < 0.0) != odd);
        }
    }
    Some(false)
}

/// The corners in ascending order, and whether an odd number of exchanges leads there.
fn sorted(triangle: [u32; 3]) -> ([u32; 3], bool) {
    let [a, b, c] = triangle;
    let mut key = triangle;
    key.sort_unstable();
    (key, [a > b, a > c, b > c].into_iter().filter(|&is_after| is_after).count() % 2 == 1)
}

/// The triangle of the file that a triangle is part of, its corners ascending, and the determinant of the weights.
fn part_of(triangle: [u32; 3], split: &Mesh) -> Option<([u32; 3], f64)> {
    let weights = weights_of(triangle, split);
    let mut key: Vec<u32> = weights.iter().flat_map(|of_corner| of_corner.keys().copied()).collect();
    key.sort_unstable();
    key.dedup();
    let key: [u32; 3] = key.try_into().ok()?;
    let rows = weights.map(|of_corner| glam::DVec3::from(key.map(|i| of_corner.get(&i).copied().unwrap_or(0.0))));
    let determinant = rows[0].dot(rows[1].cross(rows[2]));
    (determinant != 0.0).then_some((key, determinant))
}

/// The weights of the file's vertices at each corner, which are dyadic fractions and exact.
fn weights_of(triangle: [u32; 3], split: &Mesh) -> [BTreeMap<u32, f64>; 3] {
    let first = (split.positions().len() - split.halved().len()) as u32;
    triangle.map(|corner| {
        // Ends stand before their middle: the last one that is left is replaced by its ends.
        let (mut weights, mut left) = (BTreeMap::new(), BTreeMap::from([(corner, 1.0)]));
        while let Some((vertex, weight)) = left.pop_last() {
            if vertex < first {
                *weights.entry(vertex).or_insert(0.0) += weight;
            } else {
                for end in split.halved()[(vertex - first) as usize] {
                    *left.entry(end).or_insert(0.0) += 0.5 * weight;
                }
            }
        }
        weights
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::mesh::MeshParts;
    use crate::scene::scene::Scene;

    const SQUARE: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    fn split(triangles: &[[u32; 3]]) -> Mesh {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Mesh::new(MeshParts { positions, triangles: triangles.to_vec(), ..MeshParts::default() }).unwrap();
        Scene::new(vec![mesh], vec![], vec![]).unwrap().split_edges(0.2).unwrap().meshes()[0].clone()
    }

    #[test]
    fn parts_of_triangles_run_around_as_these_do_unless_a_mirror_turns_them() {
        let turned = SQUARE.map(|[a, b, c]| [a, c, b]);
        assert_eq!(is_turned(&SQUARE, &split(&SQUARE)), Some(false), "as it is");
        assert_eq!(is_turned(&turned, &split(&SQUARE)), Some(true), "the mirror");
        let both = [SQUARE, turned].concat();
        assert_eq!(is_turned(&both, &split(&SQUARE)), Some(false), "nothing to tell them by");
        // A copy of a vertex, the same one twice, in place of it.
        let mut parts = split(&SQUARE).into_parts();
        let copy = parts.positions.len() as u32;
        parts.positions.push(parts.positions[2]);
        parts.normals.push(parts.normals[2]);
        parts.halved.push([2, 2]);
        parts.triangles.iter_mut().flatten().filter(|i| **i == 2).for_each(|i| *i = copy);
        assert_eq!(is_turned(&SQUARE, &Mesh::new(parts).unwrap()), Some(false), "with a copy of a vertex");
        let most = [&turned[..], &SQUARE[..1]].concat();
        assert_eq!(is_turned(&most, &split(&SQUARE)), Some(true), "one triangle tells");
        assert_eq!(is_turned(&[[0, 1, 3], [1, 2, 3]], &split(&SQUARE)), None, "another diagonal");
    }
}
