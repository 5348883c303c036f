//! Clipping of lat-long texels at the horizon of a surface: their irradiance on both of its sides.
//!
//! The irradiance on both sides together is the integral `A` of
//!
//! ```text
//!   |h sin θ + n_z cos θ| sin θ dθ dφ           n·s = h sin θ + n_z cos θ,   h = n_x cos φ + n_y sin φ
//! ```
//!
//! and that on one side is `∫ max(n·s, 0) ds = (A + n·V)/2`, with the exact `V = ∫ s ds`: the two sides differ by
//! `n·V` exactly, whatever the error of `A`. One dimension of `A` is integrated in closed form on both sides of the
//! horizon, the other by two Gauss nodes:
//!
//! ```text
//!   flat horizon     θ in closed form at two φ:   h (θ - sin θ cos θ)/2 + n_z sin²θ/2     to θ*, tan θ* = -n_z/h
//!   steep horizon    φ in closed form at two θ:   sin θ (r sin θ sin ψ + n_z cos θ ψ)     to ψ*, cos ψ* = -n_z cot θ/r
//! ```
//!
//! `ψ = φ - φ_n`, `r² = n_x² + n_y²`. A column is flat if the horizon falls by no more than one row in it. The
//! integrand at the nodes then has a continuous slope, and the error is of fourth order in the size of a texel. Columns
//! wider than an eighth of a turn are not small: [`irradiance_at`](crate::irradiance_at) splits them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::Range;

use lobe_sh::Dir;

use crate::mapping::lat_long::sin_cos_pi;

/// Two-point Gauss quadrature in `[-1, 1]`; both weights are 1.
const NODES: [f64; 2] = [-0.577_350_269_189_625_8, 0.577_350_269_189_625_8];

/// The grid of a map, prepared for any normal.
pub(crate) struct Horizon {
    width: usize,
    height: usize,
    /// `cos φ` and `sin φ` of the left edge of every column, and of the right edge of the last.
    edges: Vec<[f64; 2]>,
    /// The same at the nodes of every column.
    nodes: Vec<[[f64; 2]; 2]>,
    /// The edges of the rows.
    latitudes: Vec<Latitude>,
    /// `sin θ` and `cos θ` at the nodes of every row.
    row_nodes: Vec<[[f64; 2]; 2]>,
}

/// A latitude, with the integrals from the pole to it.
#[derive(Clone, Copy)]
struct Latitude {
    theta: f64,
    /// `∫ sin²θ dθ = (θ - sin θ cos θ)/2`.
    a: f64,
    /// `∫ sin θ cos θ dθ = sin²θ/2`.
    b: f64,
}

impl Latitude {
    fn new(theta: f64, sin: f64, cos: f64) -> Self {
        Self { theta, a: 0.5 * (theta - sin * cos), b: 0.5 * sin * sin }
    }

    /// The horizon `θ*` where `n·s` is 0; it is positive above, towards +z, if `n_z >= 0`, and else below.
    fn of_horizon(h: f64, n_z: f64) -> Self {
        // Remove the sign of zero: the angle of (0, -0) is π.
        let (h, z) = if n_z < 0.0 { (-h + 0.0, -n_z) } else { (h + 0.0, n_z + 0.0) };
        let alpha = h.atan2(z);
        let r = h.hypot(z);
        let (sin, cos) = if r > 0.0 { (z / r, -h / r) } else { (1.0, 0.0) };
        Self::new(alpha + FRAC_PI_2, sin, cos)
    }
}

impl Horizon {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let (w, h) = (width as f64, height as f64);
        // φ = π (1 - 2u).
        let column = |u: f64| {
            let (sin, cos) = sin_cos_pi((w - 2.0 * u) / w);
            [cos, sin]
        };
        let row_node = |v: f64| {
            let (sin, cos) = sin_cos_pi(v / h);
            [sin, cos]
        };
        let at = |i: usize, node: f64| i as f64 + 0.5 + 0.5 * node;
        let latitude = |y: usize| {
            let (sin, cos) = sin_cos_pi(y as f64 / h);
            Latitude::new(PI * y as f64 / h, sin, cos)
        };
        Self {
            width,
            height,
            edges: (0..=width).map(|x| column(x as f64)).collect(),
            nodes: (0..width).map(|x| NODES.map(|node| column(at(x, node)))).collect(),
            latitudes: (0..=height).map(latitude).collect(),
            row_nodes: (0..height).map(|y| NODES.map(|node| row_node(at(y, node)))).collect(),
        }
    }

    /// Calls `visit(x, y, both)` for every texel that the horizon of `n` cuts, and for some next to them, the same for
    /// `-n`, with `both = ∫_texel |n·s| ds`.
    pub(crate) fn for_each_cut(&self, n: Dir, mut visit: impl FnMut(usize, usize, f64)) {
        let [n_x, n_y, n_z] = n.to_array();
        let h = |[cos, sin]: [f64; 2]| n_x * cos + n_y * sin;
        let (r, phi_n) = (n_x.hypot(n_y), n_y.atan2(n_x));
        let mut left = Latitude::of_horizon(h(self.edges[0]), n_z);
        for x in 0..self.width {
            let right = Latitude::of_horizon(h(self.edges[x + 1]), n_z);
            let steep = (left.theta - right.theta).abs() > PI / self.height as f64;
            let (low, high) = (left.theta.min(right.theta), left.theta.max(right.theta));
            if steep {
                let column = Column::new(x, self.width, phi_n);
                for y in self.rows(n_z, low, high) {
                    visit(x, y, self.steep_share(r, n_z, &column, y));
                }
            } else {
                let nodes = self.nodes[x].map(|node| (h(node), Latitude::of_horizon(h(node), n_z)));
                // Where the horizon turns, a node may lie beyond both edges.
                let low = nodes.iter().fold(low, |low, (_, node)| low.min(node.theta));
                let high = nodes.iter().fold(high, |high, (_, node)| high.max(node.theta));
                for y in self.rows(n_z, low, high) {
                    visit(x, y, self.flat_share(n_z, nodes, y));
                }
            }
            left = right;
        }
    }

    /// The rows that the horizon cuts in a column, if it runs between two latitudes there.
    fn rows(&self, n_z: f64, low: f64, high: f64) -> Range<usize> {
        let row = |theta: f64| ((theta * self.height as f64 / PI) as usize).min(self.height - 1);
        match (n_z == 0.0, low < high) {
            (false, _) => row(low)..row(high) + 1,
            // An upright horizon runs through all rows of a column or does not cut it.
            (true, true) => 0..self.height,
            (true, false) => 0..0,
        }
    }

    /// `∫_texel |n·s| ds` under a flat horizon: `θ` in closed form at two `φ`; `nodes` holds `h` and the horizon.
    fn flat_share(&self, n_z: f64, nodes: [(f64, Latitude); 2], y: usize) -> f64 {
        let (top, bottom) = (self.latitudes[y], self.latitudes[y + 1]);
        let share = |(h, horizon): (f64, Latitude)| {
            let horizon = match horizon.theta {
                theta if theta <= top.theta => top,
                theta if theta >= bottom.theta => bottom,
                _ => horizon,
            };
            let above = h * (horizon.a - top.a) + n_z * (horizon.b - top.b);
            let below = h * (bottom.a - horizon.a) + n_z * (bottom.b - horizon.b);
            if n_z < 0.0 { below - above } else { above - below }
        };
        nodes.into_iter().map(share).sum::<f64>() * PI / self.width as f64
    }

    /// `∫_texel |n·s| ds` under a steep horizon: `φ` in closed form at two `θ`.
    fn steep_share(&self, r: f64, n_z: f64, column: &Column, y: usize) -> f64 {
        let Column { start, step, chord } = *column;
        let share = |[sin, cos]: [f64; 2]| {
            let half = (-n_z * cos / (r * sin)).clamp(-1.0, 1.0).acos();
            let lit = |center: f64| {
                let from = (start - center).max(-half);
                let to = (start + step - center).min(half);
                if to > from { r * sin * (to.sin() - from.sin()) + n_z * cos * (to - from) } else { 0.0 }
            };
            sin * (2.0 * (lit(0.0) + lit(TAU)) - (r * sin * chord + n_z * cos * step))
        };
        self.row_nodes[y].into_iter().map(share).sum::<f64>() * 0.5 * PI / self.height as f64
    }
}

/// A column, in azimuths relative to that of a normal.
struct Column {
    /// `ψ` of the lower end, in `[-π, π)`: light comes from around `ψ = 0` and, beyond the seam, around `2π`.
    start: f64,
    step: f64,
    /// `∫ cos ψ dψ`.
    chord: f64,
}

impl Column {
    fn new(x: usize, width: usize, phi_n: f64) -> Self {
        let step = TAU / width as f64;
        let start = (PI - (x as f64 + 1.0) * step - phi_n + PI).rem_euclid(TAU) - PI;
        Self { start, step, chord: (start + step).sin() - start.sin() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `∫_texel |n·s| ds` by the midpoints of a fine grid.
    fn by_midpoints(n: Dir, (width, height): (usize, usize), x: usize, y: usize) -> f64 {
        const FINE: usize = 100;
        let mut sum = 0.0;
        for j in 0..FINE {
            let theta = PI * (y as f64 + (j as f64 + 0.5) / FINE as f64) / height as f64;
            for i in 0..FINE {
                let u = (x as f64 + (i as f64 + 0.5) / FINE as f64) / width as f64;
                sum += n.dot(Dir::from_angles(theta, PI * (1.0 - 2.0 * u))).abs() * theta.sin();
            }
        }
        sum * TAU * PI / (width * height * FINE * FINE) as f64
    }

    #[test]
    fn what_both_sides_see_of_a_cut_texel_is_its_integral() {
        let size @ (width, height) = (12, 7);
        let horizon = Horizon::new(width, height);
        let texel = TAU * PI / (width * height) as f64;
        for v in lobe_testkit::directions().into_iter().step_by(7) {
            let n = Dir::new(v).unwrap();
            horizon.for_each_cut(n, |x, y, both| {
                let expected = by_midpoints(n, size, x, y);
                // The irradiance of one side holds half of it and half of the exact n·V.
                let error = 0.5 * (both - expected).abs() / texel;
                assert!(error < 2e-3, "facing {n:?}, texel ({x}, {y}): {both} against {expected}");
            });
        }
    }

    #[test]
    fn both_sides_visit_the_same_texels() {
        for (width, height) in [(1, 1), (2, 1), (3, 5), (16, 9)] {
            let horizon = Horizon::new(width, height);
            for v in lobe_testkit::directions() {
                let visited = |n: Dir| {
                    let mut visited = Vec::new();
                    horizon.for_each_cut(n, |x, y, _| visited.push((x, y)));
                    visited
                };
                let n = Dir::new(v).unwrap();
                assert_eq!(visited(n), visited(-n), "{width} x {height}, facing {n:?}");
            }
        }
    }

    #[test]
    fn texels_that_are_not_visited_lie_on_one_side() {
        let (width, height) = (16, 9);
        let horizon = Horizon::new(width, height);
        for v in lobe_testkit::directions() {
            let n = Dir::new(v).unwrap();
            let mut visited = vec![false; width * height];
            horizon.for_each_cut(n, |x, y, _| visited[y * width + x] = true);
            for (i, _) in visited.iter().enumerate().filter(|(_, visited)| !**visited) {
                let (x, y) = (i % width, i / width);
                let corner = |dx: f64, dy: f64| {
                    let u = (x as f64 + dx) / width as f64;
                    n.dot(Dir::from_angles(PI * (y as f64 + dy) / height as f64, PI * (1.0 - 2.0 * u)))
                };
                let corners = [corner(0.01, 0.01), corner(0.99, 0.01), corner(0.01, 0.99), corner(0.99, 0.99)];
                let same = corners.iter().all(|c| *c >= -1e-9) || corners.iter().all(|c| *c <= 1e-9);
                assert!(same, "facing {n:?}, texel ({x}, {y}) is cut: {corners:?}");
            }
        }
    }
}
