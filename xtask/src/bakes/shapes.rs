//! Shapes of the scenes, z up, all of them with normals.

use std::f64::consts::{PI, TAU};

use crate::bakes::vectors::{Vector, across, add, cross, normalized, scaled, sub, turned};

/// Triangles of one color.
pub(super) struct Part {
    pub(super) name: String,
    pub(super) positions: Vec<Vector>,
    pub(super) normals: Vec<Vector>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) color: Vector,
    pub(super) double_sided: bool,
}

/// A scene under construction: parts of the color that was asked for last.
#[derive(Default)]
pub(super) struct Shapes {
    pub(super) parts: Vec<Part>,
}

impl Shapes {
    fn add(&mut self, name: &str, color: Vector) -> &mut Part {
        let part = Part {
            name: name.to_owned(),
            positions: Vec::new(),
            normals: Vec::new(),
            triangles: Vec::new(),
            color,
            double_sided: false,
        };
        self.parts.push(part);
        let last = self.parts.len() - 1;
        &mut self.parts[last]
    }

    /// A double-sided parallelogram of `n` by `m` cells, whose front is where u, v and the normal are right-handed.
    pub(super) fn sheet(&mut self, name: &str, [o, u, v]: [Vector; 3], [n, m]: [u32; 2], color: Vector) {
        let part = self.add(name, color);
        part.double_sided = true;
        let normal = normalized(cross(u, v));
        for j in 0..=m {
            for i in 0..=n {
                let along = scaled(u, f64::from(i) / f64::from(n));
                part.vertex(add(add(o, along), scaled(v, f64::from(j) / f64::from(m))), normal);
            }
        }
        part.cells([n, m], |_| [true; 2]);
    }

    /// A box between two corners, turned by degrees about an axis through the point `at`, which it is moved to: twelve
    /// single-sided triangles.
    pub(super) fn block(
        &mut self,
        name: &str,
        [low, high]: [Vector; 2],
        (axis, degrees): (Vector, f64),
        at: Vector,
        color: Vector,
    ) {
        let part = self.add(name, color);
        let place = |p: Vector| add(turned(p, axis, degrees), at);
        for k in 0..3 {
            for is_high in [false, true] {
                let (b, c) = if is_high { ((k + 1) % 3, (k + 2) % 3) } else { ((k + 2) % 3, (k + 1) % 3) };
                let mut normal = [0.0; 3];
                normal[k] = if is_high { 1.0 } else { -1.0 };
                let first = part.positions.len() as u32;
                for (s, t) in [(false, false), (true, false), (true, true), (false, true)] {
                    let mut p = low;
                    p[k] = if is_high { high[k] } else { low[k] };
                    p[b] = if s { high[b] } else { low[b] };
                    p[c] = if t { high[c] } else { low[c] };
                    part.vertex(place(p), turned(normal, axis, degrees));
                }
                part.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            }
        }
    }

    /// An ellipsoid of these radii.
    pub(super) fn ball(&mut self, name: &str, center: Vector, radii: Vector, [n, m]: [u32; 2], color: Vector) {
        let part = self.add(name, color);
        for j in 0..=m {
            for i in 0..=n {
                let (theta, phi) = (PI * f64::from(j) / f64::from(m), TAU * f64::from(i) / f64::from(n));
                let d = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
                let p = std::array::from_fn(|k| d[k] * radii[k]);
                let q = std::array::from_fn(|k| d[k] / radii[k]);
                part.vertex(add(center, p), normalized(q));
            }
        }
        // Rows run downwards, so that cells are turned around; those at the poles are triangles.
        part.cells([n, m], |j| [j > 0, j < m - 1]);
        part.flip();
    }

    /// A cylinder with its caps.
    pub(super) fn rod(&mut self, name: &str, [a, b]: [Vector; 2], radius: f64, n: u32, color: Vector) {
        let part = self.add(name, color);
        let axis = normalized(sub(b, a));
        let (u, v) = across(axis);
        let rim = |i: u32| {
            let angle = TAU * f64::from(i) / f64::from(n);
            add(scaled(u, angle.cos()), scaled(v, angle.sin()))
        };
        for end in [a, b] {
            for i in 0..=n {
                part.vertex(add(end, scaled(rim(i), radius)), rim(i));
            }
        }
        part.cells([n, 1], |_| [true; 2]);
        for (end, is_top) in [(a, false), (b, true)] {
            let normal = scaled(axis, if is_top { 1.0 } else { -1.0 });
            let hub = part.positions.len() as u32;
            part.vertex(end, normal);
            (0..n).for_each(|i| part.vertex(add(end, scaled(rim(i), radius)), normal));
            for i in 0..n {
                let (p, q) = (hub + 1 + i, hub + 1 + (i + 1) % n);
                part.triangles.push(if is_top { [hub, p, q] } else { [hub, q, p] });
            }
        }
    }

    /// A trefoil knot about the z axis: a tube of `n` rings of `m` cells.
    pub(super) fn knot(
        &mut self,
        name: &str,
        center: Vector,
        [size, radius]: [f64; 2],
        [n, m]: [u32; 2],
        color: Vector,
    ) {
        /// The step of the difference quotient that gives the direction of the tube.
        const STEP: f64 = 1e-4;
        let part = self.add(name, color);
        let curve = |t: f64| {
            let r = 2.0 + (3.0 * t).cos();
            scaled([r * (2.0 * t).cos(), r * (2.0 * t).sin(), (3.0 * t).sin()], size / 3.0)
        };
        for i in 0..=n {
            let t = TAU * f64::from(i) / f64::from(n);
            let along = normalized(sub(curve(t + STEP), curve(t - STEP)));
            let u = normalized(cross(along, [0.0, 0.0, 1.0]));
            let v = cross(along, u);
            for j in 0..=m {
                let angle = TAU * f64::from(j) / f64::from(m);
                let d = add(scaled(u, angle.cos()), scaled(v, angle.sin()));
                part.vertex(add(add(center, curve(t)), scaled(d, radius)), d);
            }
        }
        part.cells([m, n], |_| [true; 2]);
    }
}

impl Part {
    fn vertex(&mut self, position: Vector, normal: Vector) {
        self.positions.push(position);
        self.normals.push(normal);
    }

    /// Adds the triangles of `m` rows of `n` cells between vertices in rows; `has` says of a row which of both it has.
    fn cells(&mut self, [n, m]: [u32; 2], has: impl Fn(u32) -> [bool; 2]) {
        for (j, i) in (0..m).flat_map(|j| (0..n).map(move |i| (j, i))) {
            let a = j * (n + 1) + i;
            let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
            let [first, second] = has(j);
            self.triangles.extend(first.then_some([a, b, d]));
            self.triangles.extend(second.then_some([b, c, d]));
        }
    }

    /// Turns all triangles around.
    fn flip(&mut self) {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bakes::vectors::dot;

    #[test]
    fn triangles_run_around_their_normals() {
        let mut shapes = Shapes::default();
        let (white, still) = ([1.0; 3], ([0.0, 0.0, 1.0], 0.0));
        shapes.sheet("sheet", [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]], [2, 3], white);
        shapes.block("block", [[-1.0; 3], [1.0, 2.0, 3.0]], still, [0.0; 3], white);
        shapes.block("turned", [[-1.0; 3], [1.0; 3]], ([1.0, 2.0, 3.0], 40.0), [5.0; 3], white);
        shapes.ball("ball", [1.0, 2.0, 3.0], [1.0, 0.5, 0.25], [16, 8], white);
        shapes.rod("rod", [[0.0; 3], [1.0, 2.0, -1.0]], 0.3, 12, white);
        shapes.knot("knot", [0.0; 3], [0.6, 0.13], [128, 16], white);
        for part in &shapes.parts {
            for t in &part.triangles {
                let [a, b, c] = t.map(|i| part.positions[i as usize]);
                let around = cross(sub(b, a), sub(c, a));
                assert!(dot(around, around) > 0.0, "{}: an area of {t:?}", part.name);
                for &i in t {
                    let cosine = dot(normalized(around), part.normals[i as usize]);
                    assert!(cosine > 0.5, "{}: {cosine} at vertex {i} of {t:?}", part.name);
                }
            }
        }
    }
}
