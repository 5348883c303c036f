//! Readers of what moves and of what shines near by, written from `docs/guide/src/formats.md` like those of `by_hand.rs`.

use std::collections::HashSet;
use std::f64::consts::PI;

use serde_json::Value;

use crate::by_hand::{Table, basis};

/// The sample points around an entity or a lamp, and where they are.
pub(crate) struct Points {
    center: [f64; 3],
    radius: f64,
    range: [f64; 2],
    spheres: usize,
    cells: usize,
    /// Sample points that a rectangle of one side does not light.
    behind: HashSet<usize>,
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

pub(crate) fn vector(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|k| number(&value[k]))
}

/// The height of a point above the plane of a rectangle.
fn height(about: &Value, point: [f64; 3]) -> f64 {
    let [corner, u, v] = ["corner", "u", "v"].map(|name| vector(&about[name]));
    let normal = [0, 1, 2].map(|k| u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
    let dot = |a: [f64; 3]| (0..3).map(|k| a[k] * normal[k]).sum::<f64>();
    (dot(point) - dot(corner)) / length(normal)
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

impl Points {
    pub(crate) fn of_field(about: &Value) -> Self {
        Self::new(about, vector(&about["center"]), number(&about["radius"]))
    }

    /// Around the middle of the rectangle, with half its longer diagonal for the radius.
    fn of_rectangle(about: &Value) -> Self {
        let [corner, u, v] = ["corner", "u", "v"].map(|name| vector(&about[name]));
        let diagonals = [1.0, -1.0].map(|sign| length([0, 1, 2].map(|k| u[k] + sign * v[k])));
        let center = [0, 1, 2].map(|k| corner[k] + 0.5 * (u[k] + v[k]));
        let mut all = Self::new(about, center, 0.5 * diagonals[0].max(diagonals[1]));
        if about["two_sided"] == false {
            let is_behind = |p: usize| height(about, all.place_of(p)) < -1e-6 * all.radius;
            all.behind = (0..all.spheres * (all.cells + 1).pow(2) + 1).filter(|p| is_behind(*p)).collect();
        }
        all
    }

    /// Where a sample point is.
    fn place_of(&self, p: usize) -> [f64; 3] {
        let side = self.cells + 1;
        let (sphere, vertex) = (p / (side * side), p % (side * side));
        if sphere == self.spheres {
            return self.center;
        }
        let [u, v] = [vertex % side, vertex / side].map(|i| 2.0 * i as f64 / self.cells as f64 - 1.0);
        let z = 1.0 - u.abs() - v.abs();
        let fold = |a: f64, b: f64| (1.0 - b.abs()).copysign(a);
        let d = if z >= 0.0 { [u, v, z] } else { [fold(u, v), fold(v, u), z] };
        // The radius at which the place among the spheres is the number of this one, by halves.
        let (mut low, mut high) = (1e-9 * self.radius, 1e9 * self.radius);
        for _ in 0..200 {
            let middle = (low * high).sqrt();
            if self.place(middle) < sphere as f64 { low = middle } else { high = middle }
        }
        [0, 1, 2].map(|k| self.center[k] + low * d[k] / length(d))
    }

    fn new(about: &Value, center: [f64; 3], radius: f64) -> Self {
        let [spheres, cells] = ["spheres", "cells"].map(|name| about[name].as_u64().unwrap() as usize);
        let range = ["inner", "outer"].map(|name| number(&about[name]));
        Self { center, radius, range, spheres, cells, behind: HashSet::new() }
    }

    /// `e + c m(r)`, the place among the spheres.
    fn place(&self, r: f64) -> f64 {
        let m = |ratio: f64| ratio.ln().abs().sqrt().copysign(ratio.ln());
        let ([a, b], m, last) = (self.range.map(m), m(r / self.radius), (self.spheres - 1) as f64);
        if self.spheres == 2 || a >= 0.0 || b <= 0.0 {
            let c = last / (b - a);
            return -a * c + c * m;
        }
        let e = (-a * last / (b - a)).round().clamp(1.0, last - 1.0);
        e + m * if m < 0.0 { -e / a } else { (last - e) / b }
    }

    /// The rows around a point that is `offset` from the center, and their weights.
    fn weights(&self, offset: [f64; 3]) -> Vec<(usize, f64)> {
        let (r, sum) = (length(offset), offset.iter().map(|c| c.abs()).sum::<f64>());
        let [x, y, z] = offset.map(|c| c / sum);
        let fold = |a: f64, b: f64| (1.0 - b.abs()).copysign(a);
        let grid = if z >= 0.0 { [x, y] } else { [fold(x, y), fold(y, x)] };
        let [(i, a), (j, b)] = grid.map(|u| {
            let at = 0.5 * (u + 1.0) * self.cells as f64;
            let first = (at as usize).min(self.cells - 1);
            (first, at - first as f64)
        });
        let side = self.cells + 1;
        let corners = [(0, 0, (1.0 - a) * (1.0 - b)), (1, 0, a * (1.0 - b)), (0, 1, (1.0 - a) * b), (1, 1, a * b)];
        let on_sphere = |k: usize, weight: f64| {
            let row = move |(di, dj)| k * side * side + (j + dj) * side + i + di;
            corners.map(|(di, dj, w)| (row((di, dj)), weight * w)).to_vec()
        };
        let (k, last) = (self.place(r), self.spheres - 1);
        if k >= last as f64 {
            return on_sphere(last, 1.0);
        }
        if k <= 0.0 {
            let part = r / (self.radius * self.range[0]);
            let center = (self.spheres * side * side, 1.0 - part);
            return [on_sphere(0, part), vec![center]].concat();
        }
        let (first, t) = (k as usize, k.fract());
        [on_sphere(first, 1.0 - t), on_sphere(first + 1, t)].concat()
    }

    /// `(z_l y_lm(d) + g_lm) / (1 + (r/R)²)` of order 3 at a point, where row `p` begins at number `start(p)` of a table.
    pub(crate) fn function_at(&self, point: [f64; 3], table: &[f64], start: impl Fn(usize) -> usize) -> [f64; 9] {
        let offset = [0, 1, 2].map(|k| point[k] - self.center[k]);
        let mut row = [0.0; 12];
        let weights = self.weights(offset);
        let sum = |is_counted: &dyn Fn(usize) -> bool| -> f64 {
            weights.iter().filter(|(p, _)| is_counted(*p)).map(|(_, weight)| weight).sum()
        };
        let grown = sum(&|_| true) / sum(&|p| !self.behind.contains(&p));
        for (p, weight) in weights.iter().filter(|(p, _)| !self.behind.contains(p)).map(|(p, w)| (*p, w * grown)) {
            row.iter_mut().zip(&table[start(p)..]).for_each(|(sum, x)| *sum += weight * x);
        }
        let r = length(offset);
        let (y, scale) = (basis(offset.map(|c| -c / r)), 1.0 + (r / self.radius).powi(2));
        std::array::from_fn(|i| (row[i.isqrt()] * y[i] + row[3 + i]) / scale)
    }
}

/// The numbers of rows of this width in any storage, one after the other; the tensor has them unless they are in clusters.
pub(crate) fn stored_rows(about: &Value, table: &Table, name: &str, width: usize) -> Vec<f64> {
    let flat = |name: &str| &table[name].1;
    match about["storage"].as_str().unwrap_or("f32") {
        "u8" => {
            let (least, step) = flat("ranges").split_at(width);
            flat(name).iter().enumerate().map(|(i, q)| least[i % width] + step[i % width] * q).collect()
        }
        "clustered" => {
            let (weights, bases, clusters) = (flat("weights"), flat("bases"), flat("clusters"));
            let count = weights.len() / clusters.len();
            let row = |(p, k): (usize, &f64)| -> Vec<f64> {
                let basis = &bases[*k as usize * (1 + count) * width..];
                let weighted = |i: usize, j: usize| weights[p * count + j] * basis[(1 + j) * width + i];
                (0..width).map(|i| basis[i] + (0..count).map(|j| weighted(i, j)).sum::<f64>()).collect()
            };
            clusters.iter().enumerate().flat_map(row).collect()
        }
        _ => flat(name).clone(),
    }
}

/// What shines at a point in red, green and blue; a ball, a rectangle, or the picture of a sequence at `t` seconds.
pub(crate) fn light_of_lamp(about: &Value, table: &Table, point: [f64; 3], t: f64) -> [[f64; 9]; 3] {
    if about["two_sided"] == false && height(about, point) <= 0.0 {
        return [[0.0; 9]; 3];
    }
    match about["shape"].as_str().unwrap() {
        "ball" => {
            let cone = cone_around(vector(&about["center"]), number(&about["radius"]), point);
            vector(&about["radiance"]).map(|color| cone.map(|c| color * c))
        }
        "rectangle" => {
            let points = Points::of_rectangle(about);
            let rows = stored_rows(about, table, "rows", 36);
            [0, 1, 2].map(|c| points.function_at(point, &rows, |p| (3 * p + c) * 12))
        }
        _ => {
            let (points, numbers) = (Points::of_rectangle(about), stored_rows(about, table, "patches", 12));
            let patches = table["radiance"].0[1];
            let of_each = numbers.len() / (12 * patches);
            let pictures = number(&about["pictures"]);
            let picture = (t * number(&about["per_second"])).floor().rem_euclid(pictures) as usize;
            let mut light = [[0.0; 9]; 3];
            for k in 0..patches {
                let of_patch = points.function_at(point, &numbers, |p| (k * of_each + p) * 12);
                for (c, light) in light.iter_mut().enumerate() {
                    let radiance = table["radiance"].1[(picture * patches + k) * 3 + c];
                    light.iter_mut().zip(of_patch).for_each(|(sum, x)| *sum += radiance * x);
                }
            }
            light
        }
    }
}

/// 1 in the cone of a ball: `2π ∫ P_l(t) dt y_lm(d)` from the cosine of its half angle to 1.
fn cone_around(center: [f64; 3], radius: f64, point: [f64; 3]) -> [f64; 9] {
    let to_center = [0, 1, 2].map(|k| center[k] - point[k]);
    let r = length(to_center);
    let c = if r > radius { (1.0 - (radius / r).powi(2)).sqrt() } else { -1.0 };
    let integrals = [1.0 - c, 0.5 * (1.0 - c * c), 0.5 * (c - c.powi(3))];
    let y = basis(to_center.map(|x| x / r));
    std::array::from_fn(|i| 2.0 * PI * integrals[i.isqrt()] * y[i])
}

/// `F_l` of a sphere of this half angle.
pub(crate) fn logarithm_of_sphere(about: &Value, table: &Table, half_angle: f64) -> Vec<f64> {
    let (u, end) = (half_angle.sin().powi(2), number(&about["fit_end"]));
    let (shape, rows) = &table["rows"];
    let n = shape[1];
    if u <= end {
        let x = 2.0 * u / end - 1.0;
        let (_, polynomials) = &table["polynomials"];
        return polynomials.chunks(8).map(|c| u * c.iter().rev().fold(0.0, |sum, c| sum * x + c)).collect();
    }
    let place = (1.0 - half_angle.cos()) * (shape[0] - 1) as f64;
    let first = (place as usize).min(shape[0] - 2);
    let t = place - first as f64;
    (0..n).map(|l| (1.0 - t) * rows[first * n + l] + t * rows[(first + 1) * n + l]).collect()
}

/// Centers and radii of spheres where joints are: for each of them the rows of its matrix, and last for the node of the entity.
pub(crate) fn posed_spheres(about: &Value, table: &Table, matrices: &[[[f64; 4]; 3]]) -> Vec<([f64; 3], f64)> {
    let (origin, centers, radii) = (vector(&about["origin"]), &table["centers"].1, &table["radii"].1);
    let determinant = |[a, b, c]: [[f64; 4]; 3]| {
        let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
        a[0] * minor(1, 2) - a[1] * minor(0, 2) + a[2] * minor(0, 1)
    };
    let posed = |k: usize| {
        let center = [0, 1, 2].map(|axis| origin[axis] + centers[3 * k + axis]);
        let (mut at, mut radius) = ([0.0; 3], 0.0);
        for four in 4 * k..4 * k + 4 {
            let (weight, matrix) = (table["weights"].1[four], matrices[table["joints"].1[four] as usize]);
            for (x, row) in at.iter_mut().zip(matrix) {
                *x += weight * (row[0] * center[0] + row[1] * center[1] + row[2] * center[2] + row[3]);
            }
            radius += weight * radii[k] * determinant(matrix).abs().cbrt();
        }
        (at, radius)
    };
    (0..radii.len()).map(posed).collect()
}
