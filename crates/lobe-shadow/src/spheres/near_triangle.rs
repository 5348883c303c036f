//! The place of a triangle nearest to a point.

use glam::DVec3;

/// Barycentric coordinates of the nearest place.
///
/// The plane is cut into the regions that project to the inside, to an edge or to a corner, which are told apart by
/// the signs of scalar products with the edges. A triangle without area is treated as its edges.
pub(crate) fn nearest_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    let square = normal.length_squared();
    if square > 0.0 {
        let part = |q: DVec3, r: DVec3| (q - p).cross(r - p).dot(normal) / square;
        let inside = [part(b, c), part(c, a), part(a, b)];
        if inside.iter().all(|&x| x >= 0.0) {
            return inside;
        }
    }
    let corners = [a, b, c];
    let on_edge = |k: usize| {
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        let length = (to - from).length_squared();
        let t = if length > 0.0 { ((p - from).dot(to - from) / length).clamp(0.0, 1.0) } else { 0.0 };
        let mut place = [0.0; 3];
        (place[k], place[(k + 1) % 3]) = (1.0 - t, t);
        (place, from.lerp(to, t).distance_squared(p))
    };
    let edges = [on_edge(0), on_edge(1), on_edge(2)];
    edges.into_iter().fold(edges[0], |best, next| if next.1 < best.1 { next } else { best }).0
}

/// A place by its barycentric coordinates.
pub(crate) fn place([a, b, c]: [DVec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    a * u + b * v + c * w
}
