//! Quadrature nodes over a texel of any mapping.

use lobe_sh::Dir;

use crate::Mapping;
use crate::mapping::azimuthal::{self, Profile, Rect};
use crate::mapping::cube;
use crate::mapping::dual_paraboloid;
use crate::mapping::mirror_ball;
use crate::mapping::octahedral;
use crate::mapping::polygon::Point;

/// Replaces `out` by directions in texel `(x, y)` with their solid angles, whose sum is the exact one of the texel.
///
/// `rule` is a Gauss-Legendre rule on `[-1, 1]`. It is applied to each smooth piece of the texel: the mapping's folds,
/// poles and rims lie between pieces. Empty for a texel outside the discs of a round picture.
pub(crate) fn nodes_into(
    mapping: Mapping,
    [width, height]: [usize; 2],
    [x, y]: [usize; 2],
    rule: &[(f64, f64)],
    out: &mut Vec<(Dir, f64)>,
) {
    nodes_of_rules_into(mapping, [width, height], [x, y], [rule; 2], out);
}

/// [`nodes_into`] with one rule across the radius of a disc and another along it; elsewhere the second is not used.
pub(crate) fn nodes_of_rules_into(
    mapping: Mapping,
    [width, height]: [usize; 2],
    [x, y]: [usize; 2],
    rules: [&[(f64, f64)]; 2],
    out: &mut Vec<(Dir, f64)>,
) {
    let rule = rules[0];
    out.clear();
    let at = |i: usize, n: usize| (2.0 * i as f64 - n as f64) / n as f64;
    let rect = Rect { x: [at(x, width), at(x + 1, width)], y: [at(y, height), at(y + 1, height)] };
    match mapping {
        Mapping::Octahedral | Mapping::EqualArea => {
            for piece in octahedral::pieces(width, height, x, y) {
                piece_nodes(mapping, &piece, rule, out);
            }
        }
        Mapping::LatLong => rectangle_nodes(mapping, &rect, rule, out),
        Mapping::Cube => {
            let (face, row) = (y / width, y % width);
            let on_face = |i: usize, t: f64| (i as f64 + 0.5 + 0.5 * t) / width as f64;
            for (a, weight) in rule {
                for (b, inner) in rule {
                    let (s, t) = (on_face(x, *a), on_face(row, *b));
                    let density = cube::density(s, t / 6.0);
                    out.push((cube::dir_from_face(face, s, t), weight * inner * density));
                }
            }
        }
        Mapping::DualParaboloid => {
            for (frame, rect) in dual_paraboloid::FRAMES.iter().zip(dual_paraboloid::texel_rects(width, height, x, y)) {
                if let Some(rect) = rect {
                    azimuthal::nodes(Profile::Paraboloid, &rect, rules, &mut |p, weight| {
                        out.push((frame.dir(Profile::Paraboloid, p), weight));
                    });
                }
            }
        }
        Mapping::Sphere | Mapping::MirrorBall | Mapping::Angular => {
            if let Some((profile, frame)) = mapping.single_disc() {
                let rect = mirror_ball::texel_rect(width, height, x, y);
                azimuthal::nodes(profile, &rect, rules, &mut |p, weight| out.push((frame.dir(profile, p), weight)));
            }
        }
    }
    normalize(out, mapping.solid_angle(width, height, x, y));
}

/// Scales the weights to the given sum; the mass of a rim's sliver too thin for the nodes goes nowhere else.
fn normalize(nodes: &mut [(Dir, f64)], sum: f64) {
    let found: f64 = nodes.iter().map(|(_, weight)| weight).sum();
    if found > 0.0 {
        for (_, weight) in nodes {
            *weight *= sum / found;
        }
    }
}

fn rectangle_nodes(mapping: Mapping, rect: &Rect, rule: &[(f64, f64)], out: &mut Vec<(Dir, f64)>) {
    let at = |[a, b]: [f64; 2], t: f64| 0.5 + 0.25 * (a + b + t * (b - a));
    for (a, weight) in rule {
        for (b, inner) in rule {
            let (u, v) = (at(rect.x, *a), at(rect.y, *b));
            if let Some(dir) = mapping.dir_from_uv(u, v) {
                out.push((dir, weight * inner * mapping.density(u, v)));
            }
        }
    }
}

/// The nodes in a polygon on one triangle of the octahedron, in the coordinates of the square `[-1, 1]²`.
fn piece_nodes(mapping: Mapping, piece: &[Point], rule: &[(f64, f64)], out: &mut Vec<(Dir, f64)>) {
    // The equal-area mapping is smooth along rays from the poles, not across them: fan out from a pole.
    let is_pole = |p: &Point| p[0].abs() == p[1].abs() && (p[0] == 0.0 || p[0].abs() == 1.0);
    let apex = piece.iter().position(is_pole);
    let is_rectangle =
        piece.len() == 4 && (0..4).all(|k| piece[k].iter().zip(piece[(k + 1) % 4]).any(|(a, b)| *a == b));
    if is_rectangle && apex.is_none() {
        let (p, q) = (piece[0], piece[2]);
        return rectangle_nodes(mapping, &Rect { x: [p[0], q[0]], y: [p[1], q[1]] }, rule, out);
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
                if let Some(dir) = mapping.dir_from_uv(u, v) {
                    out.push((dir, weight * inner * s * area * mapping.density(u, v)));
                }
            }
        }
    }
}
