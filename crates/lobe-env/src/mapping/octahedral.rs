//! Octahedral mapping: the sphere projected onto an octahedron, its lower half folded out to a square.
//!
//! ```text
//!   (a, b) = (x, y)/(|x| + |y| + |z|)                                 z >= 0
//!          = ((1 - |y|/n) sgn x, (1 - |x|/n) sgn y), n as above       z < 0
//!   u = (1 + a)/2      v = (1 + b)/2
//!
//!    -z------ -y ------ -z        Looking up from inside, +x to the right.
//!     | \      |      / |         The inner square, |a| + |b| <= 1, is the upper half;
//!     |   \    |    /   |         the four corners are one direction, -z. Each side of
//!     |     \  |  /     |         the picture is folded in its middle: its left half
//!    -x ----- +z ----- +x         joins its right half, its upper the lower.
//!     |     /  |  \     |
//!     |   /    |    \   |
//!     | /      |      \ |
//!    -z------ +y ------ -z
//! ```
//!
//! The density is `4/|p|³`, `p` the point of the octahedron `|x| + |y| + |z| = 1`: between 4 on the axes and `12√3` in
//! the middle of its faces.
//!
//! Praun and Hoppe 2003; Engelhardt and Dachsbacher 2008.

use std::ops::Range;

use lobe_sh::Dir;

use crate::mapping::form::{Form, Pair, Plane, Rule, add_rectangle};
use crate::mapping::polygon::{Point, clip, doubled_area, triangle_solid_angle};
use crate::mapping::taps::{Taps, for_each_corner};

/// The direction of the point `(u, v)` of the picture; both are clamped to `[0, 1]`.
///
/// ```
/// use lobe_env::octahedral::dir_from_uv;
/// use lobe_sh::Dir;
///
/// assert_eq!(dir_from_uv(0.5, 0.5), Dir::Z);
/// assert_eq!(dir_from_uv(1.0, 0.5), Dir::X);
/// assert_eq!(dir_from_uv(0.5, 1.0), Dir::Y);
/// ```
#[must_use]
pub fn dir_from_uv(u: f64, v: f64) -> Dir {
    let p = unfolded(square(u), square(v));
    let scale = 1.0 / (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
    Dir::from_unit(p.map(|c| c * scale))
}

/// The point `(u, v)` of the picture in the direction `s`; `(1, 1)` for -z.
#[must_use]
pub fn uv_from_dir(s: Dir) -> (f64, f64) {
    let norm = s.x().abs() + s.y().abs() + s.z().abs();
    let (a, b) = (s.x() / norm, s.y() / norm);
    let (a, b) = if s.z() < 0.0 { ((1.0 - b.abs()) * sign(a), (1.0 - a.abs()) * sign(b)) } else { (a, b) };
    (0.5 + 0.5 * a, 0.5 + 0.5 * b)
}

/// The exact solid angle in steradian of texel `(x, y)` of a picture of `width` x `height` texels.
///
/// The texel is cut along the folds; each piece is a polygon on a face of the octahedron, seen from its center.
///
/// # Panics
/// If there is no such texel.
#[must_use]
pub fn solid_angle(width: usize, height: usize, x: usize, y: usize) -> f64 {
    pieces(width, height, x, y).iter().map(|piece| piece_solid_angle(piece)).sum()
}

/// The solid angle per area `du dv`.
pub(crate) fn density(u: f64, v: f64) -> f64 {
    let [x, y, z] = unfolded(square(u), square(v));
    let r2 = x * x + y * y + z * z;
    4.0 / (r2 * r2.sqrt())
}

/// The texel in the coordinates `(a, b)` of the square `[-1, 1]²`, cut along the folds of the octahedron.
pub(crate) fn pieces(width: usize, height: usize, x: usize, y: usize) -> Vec<Vec<Point>> {
    assert!(x < width && y < height, "no texel ({x}, {y}) in a picture of {width} x {height}");
    let at = |i: usize, n: usize| (2.0 * i as f64 - n as f64) / n as f64;
    let (a0, a1, b0, b1) = (at(x, width), at(x + 1, width), at(y, height), at(y + 1, height));
    let mut pieces = vec![vec![[a0, b0], [a1, b0], [a1, b1], [a0, b1]]];
    let folds: [fn(Point) -> f64; 6] = [
        |p| p[0],
        |p| p[1],
        |p| 1.0 - p[0] - p[1],
        |p| 1.0 + p[0] - p[1],
        |p| 1.0 - p[0] + p[1],
        |p| 1.0 + p[0] + p[1],
    ];
    for side in folds {
        let crosses = |piece: &[Point]| piece.iter().any(|&p| side(p) > 0.0) && piece.iter().any(|&p| side(p) < 0.0);
        if pieces.iter().any(|piece| crosses(piece)) {
            pieces = pieces.iter().flat_map(|piece| [clip(piece, side), clip(piece, |p| -side(p))]).collect();
            pieces.retain(|piece| doubled_area(piece) > 0.0);
        }
    }
    pieces
}

fn piece_solid_angle(piece: &[Point]) -> f64 {
    // The centroid decides on which face the piece lies: its corners may lie on several.
    let count = piece.len() as f64;
    let middle = [0, 1].map(|k| piece.iter().map(|p| p[k]).sum::<f64>() / count);
    let face = Face::of(middle);
    let corners: Vec<[f64; 3]> = piece.iter().map(|&p| face.point(p)).collect();
    corners[1..].windows(2).map(|pair| triangle_solid_angle(corners[0], pair[0], pair[1]).abs()).sum()
}

/// One of the eight triangles, on which the unfolding is affine.
struct Face {
    upper: bool,
    sign: [f64; 2],
}

impl Face {
    fn of([a, b]: Point) -> Self {
        Self { upper: a.abs() + b.abs() <= 1.0, sign: [sign(a), sign(b)] }
    }

    /// The point of the octahedron; also a little outside the triangle.
    fn point(&self, [a, b]: Point) -> [f64; 3] {
        let [sa, sb] = self.sign;
        let z = 1.0 - sa * a - sb * b;
        if self.upper { [a, b, z] } else { [sa * (1.0 - sb * b), sb * (1.0 - sa * a), z] }
    }
}

/// The point of the octahedron at `(a, b)`.
fn unfolded(a: f64, b: f64) -> [f64; 3] {
    Face::of([a, b]).point([a, b])
}

/// `[0, 1]` to `[-1, 1]`, clamped.
fn square(u: f64) -> f64 {
    (2.0 * u - 1.0).clamp(-1.0, 1.0)
}

/// 1 or -1, 1 for both zeros.
pub(crate) fn sign(x: f64) -> f64 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

/// The mapping to the unfolded octahedron.
pub(crate) struct Octahedral;

impl Form for Octahedral {
    fn name(&self) -> &'static str {
        "octahedral"
    }

    fn description(&self) -> &'static str {
        "The octahedron, unfolded"
    }

    fn dir_from_uv(&self, u: f64, v: f64) -> Option<Dir> {
        Some(dir_from_uv(u, v))
    }

    fn uv_from_dir(&self, s: Dir) -> (f64, f64) {
        uv_from_dir(s)
    }

    fn solid_angle(&self, [width, height]: Pair, [x, y]: Pair) -> f64 {
        solid_angle(width, height, x, y)
    }

    fn density(&self, u: f64, v: f64) -> f64 {
        density(u, v)
    }

    /// The point of the octahedron is at the distance `1/(|x| + |y| + |z|)`.
    fn density_towards(&self, s: Dir) -> f64 {
        let [x, y, z] = s.to_array().map(f64::abs);
        4.0 * (x + y + z).powi(3)
    }

    fn axes_again(&self) -> &'static [(&'static str, [f64; 2])] {
        &CORNERS
    }

    fn taps(&self, size: Pair, p: [f64; 2]) -> Taps {
        folded_taps(size, p)
    }

    fn add_nodes(&self, size: Pair, texel: Pair, [rule, _]: [&Rule; 2], out: &mut Vec<(Dir, f64)>) {
        add_folded_nodes(self, size, texel, rule, out);
    }

    fn planes(&self, size: Pair) -> Vec<Plane> {
        (0..8).filter_map(|k| plane(k, size)).collect()
    }

    fn plane_of(&self, [width, height]: Pair, [x, y]: Pair) -> Option<usize> {
        let bit = |i: usize, n: usize| (2 * i + 1 != n).then_some(usize::from(2 * i + 1 > n));
        Some(bit(x, width)? | bit(y, height)? << 1 | usize::from(is_lower([width, height], [x, y])?) << 2)
    }
}

/// The axis in the corners of the picture, in those other than the one at `(1, 1)`.
pub(crate) const CORNERS: [(&str, [f64; 2]); 3] = [("-z", [0.0, 0.0]), ("-z", [1.0, 0.0]), ("-z", [0.0, 1.0])];

/// Beyond a side comes the same side, rotated about its middle.
pub(crate) fn folded_taps([width, height]: Pair, p: [f64; 2]) -> Taps {
    let (w, h) = (width as isize, height as isize);
    let mut taps = Taps::NONE;
    for_each_corner(p, |x, y, weight| {
        let beyond = (x < 0 || x >= w, y < 0 || y >= h);
        let (cx, cy) = (x.clamp(0, w - 1), y.clamp(0, h - 1));
        let (x, y) = (if beyond.1 { w - 1 - cx } else { cx }, if beyond.0 { h - 1 - cy } else { cy });
        taps.push(y as usize * width + x as usize, weight);
    });
    taps
}

/// Nodes in each piece of a texel between the folds.
pub(crate) fn add_folded_nodes(
    form: &impl Form,
    [width, height]: Pair,
    [x, y]: Pair,
    rule: &Rule,
    out: &mut Vec<(Dir, f64)>,
) {
    for piece in pieces(width, height, x, y) {
        add_piece(form, &piece, rule, out);
    }
}

/// The nodes in a polygon on one triangle of the octahedron, in the coordinates of the square `[-1, 1]²`.
fn add_piece(form: &impl Form, piece: &[Point], rule: &Rule, out: &mut Vec<(Dir, f64)>) {
    // The equal-area mapping is smooth along rays from the poles, not across them: fan out from a pole.
    let is_pole = |p: &Point| p[0].abs() == p[1].abs() && (p[0] == 0.0 || p[0].abs() == 1.0);
    let apex = piece.iter().position(is_pole);
    let is_rectangle =
        piece.len() == 4 && (0..4).all(|k| piece[k].iter().zip(piece[(k + 1) % 4]).any(|(a, b)| *a == b));
    if is_rectangle && apex.is_none() {
        let (p, q) = (piece[0], piece[2]);
        return add_rectangle(form, [[p[0], q[0]], [p[1], q[1]]], rule, out);
    }
    let apex = apex.unwrap_or(0);
    let corner = |k: usize| piece[(apex + k) % piece.len()];
    let a = corner(0);
    for k in 1..piece.len() - 1 {
        let (b, c) = (corner(k), corner(k + 1));
        let area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
        for (s, weight) in rule {
            let s = 0.5 + 0.5 * s;
            for (t, inner) in rule {
                let t = 0.5 + 0.5 * t;
                let p = [0, 1].map(|i| a[i] + s * (b[i] - a[i] + t * (c[i] - b[i])));
                let (u, v) = (0.5 + 0.5 * p[0], 0.5 + 0.5 * p[1]);
                if let Some(dir) = form.dir_from_uv(u, v) {
                    out.push((dir, weight * inner * s * area * form.density(u, v)));
                }
            }
        }
    }
}

/// The face of the octahedron with the bits of `k`: right, lower in the picture, lower half of the sphere.
fn plane(k: usize, [width, height]: Pair) -> Option<Plane> {
    let sign = |bit: usize| if k & bit == 0 { -1.0 } else { 1.0 };
    let (sa, sb) = (sign(1), sign(2));
    let side = |n: usize, sign: f64| if sign < 0.0 { 0..n / 2 } else { n.div_ceil(2)..n };
    let texels = [side(width, sa), side(height, sb)];
    let (origin, right, down) = if k & 4 == 0 {
        ([0.0, 0.0, 1.0], [1.0, 0.0, -sa], [0.0, 1.0, -sb])
    } else {
        ([sa, sb, 1.0], [0.0, -sa * sb, -sa], [-sa * sb, 0.0, -sb])
    };
    let is_empty = texels.iter().any(Range::is_empty);
    (!is_empty).then_some(Plane { number: k, origin, right, down, frame: [0..width, 0..height], texels })
}

/// Whether a texel lies in the lower half of the sphere, as a whole: `|a| + |b| <= 1` is the upper one.
fn is_lower([width, height]: Pair, [x, y]: Pair) -> Option<bool> {
    let edges = |i: usize, n: usize| {
        let (p, q) = ((2 * i).abs_diff(n) as u128, (2 * i + 2).abs_diff(n) as u128);
        (p.min(q), p.max(q))
    };
    let ((a0, a1), (b0, b1)) = (edges(x, width), edges(y, height));
    let (w, h) = (width as u128, height as u128);
    if a1 * h + b1 * w <= w * h {
        return Some(false);
    }
    (a0 * h + b0 * w >= w * h).then_some(true)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn corners_are_straight_down_and_sides_fold_in_their_middle() {
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            assert!(dir_from_uv(u, v).angle_to(-Dir::Z) < 1e-15, "({u}, {v}): {:?}", dir_from_uv(u, v));
        }
        for t in [0.1, 0.3, 0.45] {
            let (left, right) = (dir_from_uv(t, 0.0), dir_from_uv(1.0 - t, 0.0));
            assert!(left.angle_to(right) < 1e-15, "upper side at {t}: {left:?} and {right:?}");
            let (upper, lower) = (dir_from_uv(1.0, t), dir_from_uv(1.0, 1.0 - t));
            assert!(upper.angle_to(lower) < 1e-15, "right side at {t}: {upper:?} and {lower:?}");
        }
    }

    #[test]
    fn the_four_triangles_around_the_top_are_octants() {
        for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let found = solid_angle(2, 2, x, y);
            assert!((found - PI).abs() < 1e-14, "quarter ({x}, {y}): {found}");
        }
        let (upper, whole) = (pieces(1, 1, 0, 0).iter().map(|p| 0.5 * doubled_area(p)).sum::<f64>(), 4.0);
        assert!((upper - whole).abs() < 1e-14, "the pieces cover the square: {upper}");
    }

    #[test]
    fn the_density_is_the_solid_angle_of_a_small_texel() {
        let n = 4096;
        for (x, y) in [(2048, 2048), (100, 3000), (1200, 1200), (4095, 4095)] {
            let at = |i: usize| (i as f64 + 0.5) / n as f64;
            let (found, exact) = (density(at(x), at(y)) / (n * n) as f64, solid_angle(n, n, x, y));
            assert!((found / exact - 1.0).abs() < 1e-3, "({x}, {y}): {found} against {exact}");
        }
    }
}
