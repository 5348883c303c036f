//! Cube faces: their axes, and their places in the unfolded cube.

use lobe_sh::Dir;

use lobe_sh::sphere::vector::{Vec3, add, scale};

/// A face of the cube `[-1, 1]³`, seen from inside.
///
/// ```text
///            +----+                   Seen from inside, like a lat-long picture:
///            | +z |                   the middle row has +z upwards and goes from
///       +----+----+----+----+         +y over +x and -y to -x; the top and the
///       | +y | +x | -y | -x |         bottom face continue the face +x.
///       +----+----+----+----+
///            | -z |
///            +----+
/// ```
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    /// The axis through the center of the face.
    pub(crate) center: Vec3,
    /// The axis to the right in the picture.
    pub(crate) right: Vec3,
    /// The axis upwards in the picture.
    pub(crate) up: Vec3,
    /// The column of the face in the unfolded cube.
    pub(crate) column: usize,
    /// The row of the face in the unfolded cube.
    pub(crate) row: usize,
    /// The name of the axis through the center.
    pub(crate) name: &'static str,
}

/// The six faces, in reading order of the unfolded cube.
pub(crate) const FACES: [Face; 6] = [
    face("+z", [0, 0, 1], [0, -1, 0], [-1, 0, 0], 1, 0),
    face("+y", [0, 1, 0], [1, 0, 0], [0, 0, 1], 0, 1),
    face("+x", [1, 0, 0], [0, -1, 0], [0, 0, 1], 1, 1),
    face("-y", [0, -1, 0], [-1, 0, 0], [0, 0, 1], 2, 1),
    face("-x", [-1, 0, 0], [0, 1, 0], [0, 0, 1], 3, 1),
    face("-z", [0, 0, -1], [0, -1, 0], [1, 0, 0], 1, 2),
];

const fn face(name: &'static str, center: [i8; 3], right: [i8; 3], up: [i8; 3], column: usize, row: usize) -> Face {
    Face { center: vec3(center), right: vec3(right), up: vec3(up), column, row, name }
}

const fn vec3([x, y, z]: [i8; 3]) -> Vec3 {
    [x as f64, y as f64, z as f64]
}

impl Face {
    /// The direction at `a` to the right and `b` upwards of the center; the edges lie at ±1, and beyond them the
    /// plane of the face goes on.
    pub(crate) fn dir(&self, a: f64, b: f64) -> Dir {
        let p = add(self.center, add(scale(self.right, a), scale(self.up, b)));
        Dir::new(p).unwrap_or_else(|| unreachable!("the point {p:?} of a face is not the origin"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_sh::sphere::vector::cross;

    #[test]
    fn faces_are_seen_from_inside() {
        for face in FACES {
            // Looking along the center axis, right × up points back to the viewer at the origin.
            assert_eq!(cross(face.right, face.up), scale(face.center, -1.0), "face {}", face.name);
        }
    }

    #[test]
    fn neighbors_on_the_unfolded_cube_share_their_edge() {
        let at = |column: usize, row: usize| FACES.into_iter().find(|f| (f.column, f.row) == (column, row));
        let mut shared = 0;
        for face in FACES {
            for t in [-1.0, -0.3, 0.0, 0.8, 1.0] {
                if let Some(right) = at(face.column + 1, face.row) {
                    assert_eq!(face.dir(1.0, t), right.dir(-1.0, t), "right of {} at {t}", face.name);
                    shared += 1;
                }
                if let Some(below) = at(face.column, face.row + 1) {
                    assert_eq!(face.dir(t, -1.0), below.dir(t, 1.0), "below {} at {t}", face.name);
                    shared += 1;
                }
            }
        }
        assert_eq!(shared, 25, "five folds, five points each");
    }
}
