//! Cube mapping: six square faces, each a central projection, stored as OpenGL, Vulkan, KTX2 and DDS store them.
//!
//! Those interfaces look a cube up with y up. Lobe's z-up world is converted by its one y-up rotation,
//!
//! ```text
//!   (X, Y, Z)_cube = (x, z, -y)_lobe          (x, y, z)_lobe = (X, -Z, Y)_cube
//! ```
//!
//! so a shader that knows a direction in a right-handed y-up world (glTF's) reads the right texel. Face `f`, its
//! center, and where its columns (`s`) and rows (`t`, downwards) lead, in the cube's axes and in Lobe's:
//!
//! ```text
//!   face     0 = +X   1 = -X   2 = +Y   3 = -Y   4 = +Z   5 = -Z
//!   s         -Z       +Z       +X       +X       +X       -X
//!   t         -Y       -Y       +Z       -Z       -Y       -Y
//!
//!   center    +x       -x       +z       -z       -y       +y       (Lobe)
//!   s         +y       -y       +x       +x       +x       -x
//!   t         -z       -z       -y       +y       -z       -z
//!
//!            +----+
//!            | +z |                   How the pictures join (Lobe's names). Read as a
//!       +----+----+----+----+         left-handed world this is what an eye in the
//!       | -x | -y | +x | +y |         center sees; in a right-handed one every face is
//!       +----+----+----+----+         the mirror image of a photograph: see
//!            | -z |                   CubeHandedness for faces that are photographs.
//!            +----+
//! ```
//!
//! As one picture the faces stand below each other in this order: `v = (f + t)/6`, `u = s`.
//!
//! OpenGL 4.6, section 8.13, table of the cube map faces.

use lobe_sh::sphere::vector::{add_scaled, dot};
use lobe_sh::{Dir, Real};

use crate::mapping::form::{Form, Pair, Plane, Rule, between_centers};
use crate::mapping::polygon::triangle_solid_angle;
use crate::mapping::taps::{Taps, for_each_corner};

/// The number of faces.
pub const FACES: usize = 6;

/// Center, direction of the columns, direction of the rows, in Lobe's axes.
const AXES: [[[f64; 3]; 3]; FACES] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]],
    [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
    [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
    [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
    [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
];

/// The direction of the point `(s, t)` of a face, `s` to the right and `t` downwards, both in `[0, 1]`.
///
/// Beyond `[0, 1]` the plane of the face continues.
///
/// # Panics
/// If `face >= 6`.
#[must_use]
pub fn dir_from_face(face: usize, s: f64, t: f64) -> Dir {
    let p = point(face, 2.0 * s - 1.0, 2.0 * t - 1.0);
    let scale = 1.0 / (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
    Dir::from_unit(p.map(|c| c * scale))
}

/// The face and the point `(s, t)` on it in the direction `d`.
///
/// On an edge between faces X wins over Y over Z, in the cube's axes.
#[must_use]
pub fn face_from_dir(d: Dir) -> (usize, f64, f64) {
    let (face, major, a, b) = major_face(d.to_array());
    (face, 0.5 * (a / major) + 0.5, 0.5 * (b / major) + 0.5)
}

/// The face in the direction of a vector of any length, the size of the coordinate that decides it, and the two others
/// along the axes of the face.
#[inline(always)]
pub(crate) fn major_face<T: Real>([x, y, z]: [T; 3]) -> (usize, T, T, T) {
    let [ax, ay, az] = [x, y, z].map(|c| if c < T::ZERO { -c } else { c });
    if ax >= az && ax >= ay {
        if x > T::ZERO { (0, ax, y, -z) } else { (1, ax, -y, -z) }
    } else if az >= ay {
        if z > T::ZERO { (2, az, x, -y) } else { (3, az, x, y) }
    } else if y < T::ZERO {
        (4, ay, x, -z)
    } else {
        (5, ay, -x, -z)
    }
}

/// The direction of the point `(u, v)` of the picture of six faces below each other; both are clamped to `[0, 1]`.
#[must_use]
pub fn dir_from_uv(u: f64, v: f64) -> Dir {
    let row = 6.0 * v.clamp(0.0, 1.0);
    let face = (row as usize).min(FACES - 1);
    dir_from_face(face, u.clamp(0.0, 1.0), row - face as f64)
}

/// The point `(u, v)` in the direction `s` of the picture of six faces below each other.
#[must_use]
pub fn uv_from_dir(s: Dir) -> (f64, f64) {
    let (face, s, t) = face_from_dir(s);
    let v = (face as f64 + t) / 6.0;
    // The lower edge of a face is the upper edge of the next in this picture: stay on the face.
    let limit = (face + 1) as f64 / 6.0;
    (s, if t > 0.5 && v >= limit && face + 1 < FACES { limit.next_down() } else { v })
}

/// The exact solid angle in steradian of texel `(x, y)` of a face of `size` x `size` texels.
///
/// The sum of two triangles seen from the center of the cube: accurate but for the last digits for every
/// size, and the sum over a face is `2π/3` (test `solid_angles_sum_to_the_whole_sphere`).
///
/// # Panics
/// If there is no such texel.
#[must_use]
pub fn solid_angle(size: usize, x: usize, y: usize) -> f64 {
    assert!(x < size && y < size, "no texel ({x}, {y}) on a face of {size} x {size}");
    let at = |i: usize| (2 * i) as f64 / size as f64 - 1.0;
    rect_solid_angle([at(x), at(x + 1)], [at(y), at(y + 1)])
}

/// The exact solid angle of a rectangle on a face, `[-1, 1]` from edge to edge.
pub(crate) fn rect_solid_angle([x0, x1]: [f64; 2], [y0, y1]: [f64; 2]) -> f64 {
    let (a, b, c, d) = ([x0, y0, 1.0], [x1, y0, 1.0], [x1, y1, 1.0], [x0, y1, 1.0]);
    triangle_solid_angle(a, b, c) + triangle_solid_angle(a, c, d)
}

/// The solid angle per area `du dv` at the point `(u, v)` of the picture of six faces below each other.
pub(crate) fn density(u: f64, v: f64) -> f64 {
    let row = 6.0 * v.clamp(0.0, 1.0);
    let t = row - row.floor().min(5.0);
    let (a, b) = (2.0 * u - 1.0, 2.0 * t - 1.0);
    let r2 = 1.0 + a * a + b * b;
    24.0 / (r2 * r2.sqrt())
}

/// The texel next to a face: column `x` of row `y`, one of them -1 or `size`, as its face, column and row.
pub(crate) fn neighbor(size: usize, face: usize, x: isize, y: isize) -> (usize, usize, usize) {
    // The middle of the edge between the two texels lies on both faces.
    let at = |i: isize| ((2 * i + 1) as f64 / size as f64 - 1.0).clamp(-1.0, 1.0);
    let p = point(face, at(x), at(y));
    let along = |axis: [f64; 3]| p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2];
    let index = |a: f64| ((0.5 * (a + 1.0) * size as f64) as usize).min(size - 1);
    let other = (0..FACES).find(|&other| other != face && along(AXES[other][0]) == 1.0);
    let other = other.unwrap_or_else(|| unreachable!("({x}, {y}) is not beside a face of {size}"));
    (other, index(along(AXES[other][1])), index(along(AXES[other][2])))
}

/// The point of the plane of a face, `a` and `b` in `[-1, 1]`.
fn point(face: usize, a: f64, b: f64) -> [f64; 3] {
    let [center, right, down] = AXES[face];
    [0, 1, 2].map(|k| center[k] + a * right[k] + b * down[k])
}

/// The mapping to six faces.
pub(crate) struct Cube;

impl Form for Cube {
    fn name(&self) -> &'static str {
        "cube"
    }

    fn description(&self) -> &'static str {
        "Six faces"
    }

    fn dir_from_uv(&self, u: f64, v: f64) -> Option<Dir> {
        Some(dir_from_uv(u, v))
    }

    fn uv_from_dir(&self, s: Dir) -> (f64, f64) {
        uv_from_dir(s)
    }

    fn solid_angle(&self, [width, height]: Pair, [x, y]: Pair) -> f64 {
        assert!(height == FACES * width, "six faces of {width} x {width} are not {width} x {height}");
        solid_angle(width, x, y % width)
    }

    fn density(&self, u: f64, v: f64) -> f64 {
        density(u, v)
    }

    /// The point of the cube is at the distance `1/max(|x|, |y|, |z|)`.
    fn density_towards(&self, s: Dir) -> f64 {
        let [x, y, z] = s.to_array().map(f64::abs);
        24.0 * x.max(y).max(z).powi(3)
    }

    fn aspect(&self) -> Pair {
        [1, FACES]
    }

    fn is_told_by(&self, _size: Pair) -> bool {
        true
    }

    fn faces(&self) -> usize {
        FACES
    }

    /// A power of two.
    fn usual_size(&self, size: f64) -> usize {
        1 << (size.log2().round() as u32)
    }

    fn lengths(&self, [width, _]: Pair, _middle: [f64; 2], center: Dir) -> [f64; 2] {
        // Moving along an axis by da turns the direction by da √(1 + b²)/(1 + a² + b²), at most da/√(1 + a² + b²).
        let [x, y, z] = center.to_array().map(f64::abs);
        [2.0 * (1.0 / width as f64) * x.max(y).max(z); 2]
    }

    fn limits(&self, [width, _]: Pair, p: [f64; 2]) -> [[f32; 2]; 2] {
        let face = face_of_row(width, p[1]);
        [[0.0, width as f32], [(face * width) as f32, (((face + 1) * width) as f32).next_down()]]
    }

    /// Beyond an edge of a face comes its neighbor, beyond a corner the mean of the three texels that meet there.
    fn taps(&self, [width, _]: Pair, [x, y]: [f64; 2]) -> Taps {
        let size = width as isize;
        let face = ((y / width as f64) as usize).min(FACES - 1);
        let inside = |i: isize| (0..size).contains(&i);
        let number = |x: isize, y: isize| {
            if inside(x) && inside(y) {
                return (face * width + y as usize) * width + x as usize;
            }
            let (face, x, y) = neighbor(width, face, x, y);
            (face * width + y) * width + x
        };
        let mut taps = Taps::NONE;
        for_each_corner([x, y - (face * width) as f64], |x, y, weight| {
            if inside(x) || inside(y) {
                taps.push(number(x, y), weight);
            } else {
                let (cx, cy) = (x.clamp(0, size - 1), y.clamp(0, size - 1));
                for (x, y) in [(cx, cy), (x, cy), (cx, y)] {
                    taps.push(number(x, y), weight / 3.0);
                }
            }
        });
        taps
    }

    fn inner_part(&self, [width, _]: Pair, p: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        Some([between_centers(0, width), between_centers(face_of_row(width, p[1]) * width, width)])
    }

    fn add_nodes(&self, [width, _]: Pair, [x, y]: Pair, [rule, _]: [&Rule; 2], out: &mut Vec<(Dir, f64)>) {
        let (face, row) = (y / width, y % width);
        let on_face = |i: usize, t: f64| (i as f64 + 0.5 + 0.5 * t) / width as f64;
        for (a, weight) in rule {
            for (b, inner) in rule {
                let (s, t) = (on_face(x, *a), on_face(row, *b));
                out.push((dir_from_face(face, s, t), weight * inner * density(s, t / 6.0)));
            }
        }
    }

    fn planes(&self, [width, _]: Pair) -> Vec<Plane> {
        (0..FACES).map(|face| plane(face, width)).collect()
    }

    fn plane_of(&self, [width, _]: Pair, [_, y]: Pair) -> Option<usize> {
        Some(y / width)
    }
}

/// The face of a row of texels.
fn face_of_row(width: usize, y: f64) -> usize {
    ((y / width as f64) as usize).min(FACES - 1)
}

fn plane(face: usize, size: usize) -> Plane {
    let origin = dir_from_face(face, 0.5, 0.5).to_array();
    let to_edge = |s: f64, t: f64| {
        let p = dir_from_face(face, s, t).to_array();
        let scale = dot(p, origin).recip();
        add_scaled(p.map(|c| c * scale), origin, -1.0)
    };
    let frame = [0..size, face * size..(face + 1) * size];
    Plane { number: face, origin, right: to_edge(1.0, 0.5), down: to_edge(0.5, 1.0), texels: frame.clone(), frame }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use lobe_testkit::directions;

    use super::*;

    /// The selection table of the OpenGL specification, on the direction with y up.
    fn opengl(d: Dir) -> (usize, f64, f64) {
        let (rx, ry, rz) = (d.x(), d.z(), -d.y());
        let (ax, ay, az) = (rx.abs(), ry.abs(), rz.abs());
        let (face, sc, tc, ma) = if ax >= ay && ax >= az {
            if rx > 0.0 { (0, -rz, -ry, ax) } else { (1, rz, -ry, ax) }
        } else if ay >= az {
            if ry > 0.0 { (2, rx, rz, ay) } else { (3, rx, -rz, ay) }
        } else if rz > 0.0 {
            (4, rx, -ry, az)
        } else {
            (5, -rx, -ry, az)
        };
        (face, 0.5 * (sc / ma + 1.0), 0.5 * (tc / ma + 1.0))
    }

    #[test]
    fn faces_are_looked_up_as_opengl_looks_them_up() {
        for v in directions() {
            let d = Dir::new(v).unwrap();
            let ((face, s, t), (gl_face, gl_s, gl_t)) = (face_from_dir(d), opengl(d));
            assert!(face == gl_face && (s - gl_s).abs() + (t - gl_t).abs() < 1e-15, "{d:?}: {face} {s} {t}, {gl_face}");
        }
    }

    #[test]
    fn mapping_and_inverse_agree_over_the_whole_sphere() {
        for v in directions() {
            let d = Dir::new(v).unwrap();
            let (face, s, t) = face_from_dir(d);
            assert!((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t), "{d:?} is at ({s}, {t})");
            assert!(d.angle_to(dir_from_face(face, s, t)) < 1e-15, "{d:?} by face {face}");
            let (u, v) = uv_from_dir(d);
            assert!(d.angle_to(dir_from_uv(u, v)) < 1e-14, "{d:?} by the picture at ({u}, {v})");
        }
    }

    #[test]
    fn the_lower_edge_of_a_face_stays_on_its_face() {
        for face in 0..FACES {
            for s in [0.2, 0.5, 0.9] {
                let edge = dir_from_face(face, s, 1.0);
                let (u, v) = uv_from_dir(edge);
                assert!(edge.angle_to(dir_from_uv(u, v)) < 1e-14, "face {face} at {s}: ({u}, {v})");
            }
        }
    }

    #[test]
    fn every_face_is_left_handed_seen_from_inside() {
        // Right x down points out of the face, along its center, in a left-handed reading; in Lobe's right-handed
        // axes it points back to the eye.
        for (face, [c, r, d]) in AXES.into_iter().enumerate() {
            let cross = [r[1] * d[2] - r[2] * d[1], r[2] * d[0] - r[0] * d[2], r[0] * d[1] - r[1] * d[0]];
            assert_eq!(cross.map(|x| x + 0.0), c.map(|x| -x + 0.0), "face {face}");
        }
    }

    #[test]
    fn solid_angles_sum_to_the_whole_sphere() {
        for size in [1, 2, 3, 7, 64, 255] {
            let sum: f64 = (0..size * size).map(|i| solid_angle(size, i % size, i / size)).sum();
            assert!((6.0 * sum - 4.0 * PI).abs() < 1e-12, "{size}: {sum}");
        }
    }

    #[test]
    fn the_density_is_the_solid_angle_of_a_small_texel() {
        let size = 4096;
        for (x, y) in [(0, 0), (2048, 2048), (4095, 7), (1000, 3000)] {
            let at = |i: usize| (i as f64 + 0.5) / size as f64;
            let density = density(at(x), at(y) / 6.0) / (6 * size * size) as f64;
            let exact = solid_angle(size, x, y);
            assert!((density / exact - 1.0).abs() < 1e-6, "({x}, {y}): {density} against {exact}");
        }
    }
}
