//! Solid angles of triangles, and clipping of polygons: for texels cut along the folds of their mapping.

use lobe_sh::sphere::vector::{cross, dot, sub};

/// The solid angle of the triangle with the given corners, seen from the origin; negative if they run clockwise.
///
/// ```text
///   tan(Ω/2) = a·(b × c) / (|a||b||c| + (a·b)|c| + (b·c)|a| + (c·a)|b|)
/// ```
///
/// The corners may have any length. The triple product is taken of the differences, `a·((b-a) × (c-a))`, so that small
/// triangles keep their digits.
///
/// Van Oosterom and Strackee 1983.
pub(crate) fn triangle_solid_angle(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    let cross = cross(sub(b, a), sub(c, a));
    let (la, lb, lc) = (dot(a, a).sqrt(), dot(b, b).sqrt(), dot(c, c).sqrt());
    let below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    2.0 * dot(a, cross).atan2(below)
}

/// A corner of a texel or of a piece of it, in the plane of the picture.
pub(crate) type Point = [f64; 2];

/// The part of the convex polygon where `side(p) >= 0`; `side` is affine.
pub(crate) fn clip(polygon: &[Point], side: impl Fn(Point) -> f64) -> Vec<Point> {
    let mut inside = Vec::with_capacity(polygon.len() + 1);
    for (k, &p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let (at_p, at_q) = (side(p), side(q));
        if at_p >= 0.0 {
            inside.push(p);
        }
        if (at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0) {
            let t = at_p / (at_p - at_q);
            inside.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
        }
    }
    inside
}

/// Twice the area of the polygon.
pub(crate) fn doubled_area(polygon: &[Point]) -> f64 {
    let Some(&first) = polygon.first() else { return 0.0 };
    let cross = |p: Point, q: Point| (p[0] - first[0]) * (q[1] - first[1]) - (p[1] - first[1]) * (q[0] - first[0]);
    polygon.windows(2).map(|pair| cross(pair[0], pair[1])).sum::<f64>().abs()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn an_octant_is_an_eighth_of_the_sphere() {
        let octant = triangle_solid_angle([2.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 3.0]);
        assert!((octant - 0.5 * PI).abs() < 1e-15, "{octant}");
    }

    #[test]
    fn small_triangles_keep_their_digits() {
        let h = 1e-7;
        let small = triangle_solid_angle([0.3, 0.4, 1.0], [0.3 + h, 0.4, 1.0], [0.3, 0.4 + h, 1.0]);
        // The density at the centroid, accurate to second order in h.
        let (x, y) = (0.3_f64 + h / 3.0, 0.4_f64 + h / 3.0);
        let expected = 0.5 * h * h * (1.0 + x * x + y * y).powf(-1.5);
        assert!((small / expected - 1.0).abs() < 1e-8, "{small} against {expected}");
    }

    #[test]
    fn clipping_keeps_the_area_of_both_sides() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let side = |p: Point| p[0] + 0.5 * p[1] - 0.7;
        let (a, b) = (clip(&square, side), clip(&square, |p| -side(p)));
        let total = 0.5 * (doubled_area(&a) + doubled_area(&b));
        assert!((total - 1.0).abs() < 1e-15 && a.len() == 4 && b.len() == 4, "{a:?} and {b:?}: {total}");
    }
}
