//! Polygons of OBJ and PLY files as triangles.

use std::collections::HashMap;

use earcut::Earcut;
use earcut::utils3d::project3d_to_2d;
use glam::DVec3;

use crate::files::source::Source;
use crate::scene::mesh::double_area;

/// Divides polygons into triangles of their own corners; keeps its memory from one polygon to the next.
///
/// A polygon that all its first corner's diagonals divide, such as a convex one, becomes the fan of these. Any other is
/// projected along its normal and its ears are cut off [Eberly 1998], so that dents stay open. Corners on the line between others stay
/// corners of triangles that have an area: a neighbor at that line may have them too, and there would be gaps between the two.
pub(crate) struct Triangulator {
    earcut: Earcut<f64>,
    corners: Vec<[f64; 3]>,
    flat: Vec<[f64; 2]>,
    ears: Vec<u32>,
    /// The triangles of a polygon, by its corners.
    own: Vec<[usize; 3]>,
    filled: usize,
}

/// The most corners of a polygon whose dents are cut: cutting ears can take time with the square of their number. No modeling
/// program makes such a face; it becomes a fan, which fills its dents, and is [counted](Triangulator::note_filled).
const MOST_CORNERS: usize = 10_000;

impl Triangulator {
    pub(crate) fn new() -> Self {
        let (corners, flat, ears, own) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { earcut: Earcut::new(), corners, flat, ears, own, filled: 0 }
    }

    /// Notes how many polygons have too many corners for their dents to stay open.
    pub(crate) fn note_filled(&self, source: &mut Source<'_>) {
        let count = self.filled;
        if count > 0 {
            source.note(format!(
                "faces of more than {MOST_CORNERS} corners: {count}, whose dents are filled; divide them into smaller ones"
            ));
        }
    }

    /// Adds the triangles of a polygon to `triangles`. Where a corner has no position, which whoever makes a mesh of
    /// the triangles refuses, they are a fan.
    pub(crate) fn push(&mut self, polygon: &[u32], positions: &[[f32; 3]], triangles: &mut Vec<[u32; 3]>) {
        let fan = (1..polygon.len().max(2) - 1).map(|k| [0, k, k + 1]);
        let corners = polygon.iter().map_while(|&i| Some(positions.get(i as usize)?.map(f64::from)));
        self.corners.clear();
        self.corners.extend(corners);
        let may_have_dent = polygon.len() >= 4 && self.corners.len() == polygon.len();
        let has_dent = may_have_dent && !self.is_divided_by(fan.clone());
        let is_large = polygon.len() > MOST_CORNERS;
        self.filled += usize::from(has_dent && is_large);
        self.ears.clear();
        if has_dent && !is_large && project3d_to_2d(&self.corners, polygon.len(), &mut self.flat) {
            self.earcut.earcut_slice(&self.flat, &[], &mut self.ears);
        }
        self.own.clear();
        if self.ears.is_empty() {
            self.own.extend(fan);
        } else {
            let is_turned = self.ears.chunks_exact(3).map(|t| self.signed_area(t)).sum::<f64>() < 0.0;
            let ears = self.ears.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|k| k as usize));
            self.own.extend(ears.map(|[a, b, c]| if is_turned { [a, c, b] } else { [a, b, c] }));
        }
        if may_have_dent {
            self.keep_corners();
        }
        triangles.extend(self.own.iter().map(|t| t.map(|k| polygon[k])));
    }

    /// Takes triangles without area out, and puts corners that no triangle has then, because they lie on the line between two others,
    /// into the triangle at that line: it becomes a fan over them.
    fn keep_corners(&mut self) {
        let (corners, count) = (&self.corners, self.corners.len());
        let has_area = |t: &[usize; 3]| double_area(t.map(|k| corners[k].map(|c| c as f32))) > 0.0;
        let are_whole = self.own.len() == count - 2 && self.own.iter().all(has_area);
        if are_whole || !self.own.iter().any(has_area) {
            return;
        }
        self.own.retain(has_area);
        let mut is_used = vec![false; count];
        let mut triangle_at = HashMap::new();
        for (index, t) in self.own.iter().enumerate() {
            for k in 0..3 {
                is_used[t[k]] = true;
                triangle_at.insert([t[k], t[(k + 1) % 3]], index);
            }
        }
        // Around the polygon once, from a corner that is used.
        let first = self.own[0][0];
        let mut line = vec![first];
        for corner in (1..=count).map(|step| (first + step) % count) {
            line.push(corner);
            if !is_used[corner] {
                continue;
            }
            if line.len() > 2
                && let Some(&index) = triangle_at.get(&[line[0], corner])
                && let Some(&top) = self.own[index].iter().find(|&&k| k != line[0] && k != corner)
            {
                self.own[index] = [line[0], line[1], top];
                self.own.extend(line[1..].windows(2).map(|part| [part[0], part[1], top]));
                triangle_at.insert([corner, top], self.own.len() - 1);
            }
            line = vec![corner];
        }
    }

    /// Whether no triangle faces away from the normal of the polygon, the sum of theirs: those of a polygon that does not
    /// cross itself overlap nowhere then.
    fn is_divided_by(&self, triangles: impl Iterator<Item = [usize; 3]> + Clone) -> bool {
        let normal_of = |t: [usize; 3]| {
            let [a, b, c] = t.map(|k| DVec3::from(self.corners[k]));
            (b - a).cross(c - a)
        };
        let normal: DVec3 = triangles.clone().map(normal_of).sum();
        triangles.map(normal_of).all(|n| n.dot(normal) >= 0.0)
    }

    /// The doubled area of a triangle in the plane, negative if it runs clockwise.
    fn signed_area(&self, t: &[u32]) -> f64 {
        let [a, b, c] = [0, 1, 2].map(|k| self.flat[t[k] as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum of the triangles' normals, of twice their area, and the sum of these areas.
    fn sums(polygon: &[[f32; 3]]) -> (DVec3, f64, usize) {
        let indices: Vec<u32> = (0..polygon.len() as u32).collect();
        let mut triangles = Vec::new();
        Triangulator::new().push(&indices, polygon, &mut triangles);
        let normals = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|i| DVec3::from(polygon[i as usize].map(f64::from)));
            (b - a).cross(c - a)
        });
        let normals: Vec<DVec3> = normals.collect();
        (normals.iter().sum(), normals.iter().map(|n| n.length()).sum(), triangles.len())
    }

    /// In the plane the vector area of a polygon has the length of its area only if nothing is covered twice.
    #[test]
    fn dented_polygons_are_covered_once_wherever_they_begin_and_whichever_way_they_face() {
        let dented = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.2], [0.0, 1.0]];
        let turns: [fn([f32; 2]) -> [f32; 3]; 4] =
            [|[x, y]| [x, y, 0.0], |[x, y]| [y, x, 0.0], |[x, y]| [0.0, x, y], |[x, y]| [x + y, x - y, 2.0 * x]];
        for (k, turn) in turns.iter().enumerate() {
            for first in 0..5 {
                let polygon: Vec<[f32; 3]> = (0..5).map(|i| turn(dented[(first + i) % 5])).collect();
                let (vector_area, area, count) = sums(&polygon);
                let message = format!("turn {k} from corner {first}: {area} over {vector_area}");
                assert!((vector_area.length() - area).abs() < 1e-6 && count == 3, "{message}");
                let (x, y) =
                    (DVec3::from(turn([1.0, 0.0]).map(f64::from)), DVec3::from(turn([0.0, 1.0]).map(f64::from)));
                // Twice 0.6 of the unit square; to the same side as it.
                assert!((vector_area - 1.2 * x.cross(y)).length() < 1e-6, "{message}");
            }
        }
    }

    #[test]
    fn faces_that_are_not_planar_keep_their_boundary_and_their_dent() {
        // A dented pentagon bent along its middle: from above it covers 0.6 of the unit square.
        let bent = [[0.0, 0.0, 0.3], [1.0, 0.0, 0.3], [1.0, 1.0, 0.3], [0.5, 0.2, 0.0], [0.0, 1.0, 0.3]];
        for first in 0..5 {
            let polygon: Vec<[f32; 3]> = (0..5).map(|i| bent[(first + i) % 5]).collect();
            let (vector_area, _, count) = sums(&polygon);
            assert!((vector_area.z - 1.2).abs() < 1e-6 && count == 3, "from corner {first}: {vector_area}");
        }
    }

    /// Neighbors that share the line of a corner have it too: without it there would be a gap between them.
    #[test]
    fn corners_on_the_line_between_others_are_corners_of_triangles_wherever_the_polygon_begins() {
        let polygons: [(&str, f64, &[[f32; 2]]); 5] = [
            ("one of a square", 2.0, &[[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
            ("two on one side", 2.0, &[[0.0, 0.0], [0.25, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
            (
                "two on each side of a triangle",
                9.0,
                &[
                    [0.0, 0.0],
                    [1.0, 0.0],
                    [2.0, 0.0],
                    [3.0, 0.0],
                    [2.0, 1.0],
                    [1.0, 2.0],
                    [0.0, 3.0],
                    [0.0, 2.0],
                    [0.0, 1.0],
                ],
            ),
            (
                "one on a side beside a dent",
                1.2,
                &[[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.2], [0.0, 1.0]],
            ),
            ("two equal ones", 2.0, &[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
        ];
        for (what, expected, corners) in polygons {
            let count = corners.len();
            for first in 0..count {
                let polygon: Vec<[f32; 3]> =
                    (0..count).map(|i| corners[(first + i) % count]).map(|[x, y]| [x, y, 1.0]).collect();
                let indices: Vec<u32> = (0..count as u32).collect();
                let mut triangles = Vec::new();
                Triangulator::new().push(&indices, &polygon, &mut triangles);
                let message = format!("{what} from corner {first}: {triangles:?}");
                let (vector_area, area, _) = sums(&polygon);
                assert!((area - expected).abs() < 1e-6 && (vector_area.z - expected).abs() < 1e-6, "{message}");
                let is_kept = |t: &&[u32; 3]| double_area(t.map(|i| polygon[i as usize])) > 0.0;
                let kept: Vec<u32> = triangles.iter().filter(is_kept).flatten().copied().collect();
                let place = |i: u32| polygon[i as usize];
                let missing: Vec<u32> =
                    indices.iter().copied().filter(|&i| !kept.iter().any(|&k| place(k) == place(i))).collect();
                assert!(missing.is_empty(), "{message}: without {missing:?}");
            }
        }
    }

    #[test]
    fn polygons_without_area_or_positions_become_fans() {
        assert_eq!(sums(&[[0.0; 3]; 5]).2, 3, "one point");
        assert_eq!(sums(&[[0.0; 3], [1.0, 0.0, 0.0]]).2, 0, "an edge");
        let mut triangles = Vec::new();
        Triangulator::new().push(&[0, 1, 2, 9], &[[0.0; 3]; 3], &mut triangles);
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 9]], "a corner that is not there");
    }
}
