//! Benchmark workload: points on surfaces and rays from each, as in a bake.

#![allow(dead_code, reason = "each benchmark uses what it needs")]

use std::f32::consts::TAU;

use lobe_testkit::Random;

/// Rays from each point.
pub(crate) const RAYS_PER_POINT: usize = 256;

/// Points that rays are sent from.
const POINTS: usize = 1024;

/// Triangles, and points among them with cosine-weighted directions.
pub(crate) struct Workload {
    pub(crate) corners: Vec<[[f32; 3]; 3]>,
    pub(crate) points: Vec<([f32; 3], Vec<[f32; 3]>)>,
}

impl Workload {
    /// A bumpy ground of `cells` × `cells` cells under 64 dented balls of `around` vertices around.
    pub(crate) fn new(cells: usize, around: usize) -> Self {
        let mut corners = Vec::new();
        patch(cells, cells, &mut corners, |u, v| {
            let (x, y) = (8.0 * (2.0 * u - 1.0), 8.0 * (2.0 * v - 1.0));
            [x, y, 0.3 * (3.0 * x).sin() * (2.3 * y).cos() + 0.1 * (9.0 * x + 7.0 * y).sin()]
        });
        for ball in 0..64 {
            let center = [(ball % 8) as f32 * 2.0 - 7.0, (ball / 8) as f32 * 2.0 - 7.0, 1.4];
            let at = |p: [f32; 3]| std::array::from_fn(|k| center[k] + p[k]);
            corners.extend(dented_ball(around).into_iter().map(|triangle| triangle.map(at)));
        }
        Self::among(corners)
    }

    /// Rays among these triangles.
    pub(crate) fn among(corners: Vec<[[f32; 3]; 3]>) -> Self {
        let mut random = Random::new(11);
        let points = (0..POINTS).map(|_| Self::point(&corners, &mut random)).collect();
        Self { corners, points }
    }

    /// The same with the directions of each point along a Z-curve through a cube.
    pub(crate) fn ordered(&self) -> Self {
        let cell = |c: f32| ((c + 1.0) * 7.99) as u32;
        let spread = |x: u32| (0..4).fold(0, |bits, k| bits | ((x >> k) & 1) << (3 * k));
        let place = |d: &[f32; 3]| spread(cell(d[0])) | spread(cell(d[1])) << 1 | spread(cell(d[2])) << 2;
        let mut points = self.points.clone();
        points.iter_mut().for_each(|(_, directions)| directions.sort_by_key(place));
        Self { corners: self.corners.clone(), points }
    }

    /// A point a little above a triangle, and its rays, in no order.
    fn point(corners: &[[[f32; 3]; 3]], random: &mut Random) -> ([f32; 3], Vec<[f32; 3]>) {
        let [a, b, c] = corners[(random.unit() * corners.len() as f64) as usize];
        let minus = |p: [f32; 3], q: [f32; 3]| -> [f32; 3] { std::array::from_fn(|k| p[k] - q[k]) };
        let (e, f) = (minus(b, a), minus(c, a));
        let n = unit([e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]]);
        let origin = std::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0 + 1e-3 * n[k]);
        let directions = (0..RAYS_PER_POINT)
            .map(|_| {
                // A unit vector on the sphere that touches the surface from above: cosine-weighted.
                let s = random.direction();
                unit(std::array::from_fn(|k| n[k] + 0.9999 * s[k] as f32))
            })
            .collect();
        (origin, directions)
    }

    /// The sum of the results of `trace` over all points.
    pub(crate) fn count(&self, mut trace: impl FnMut([f32; 3], &[[f32; 3]]) -> usize) -> usize {
        self.points.iter().map(|(origin, directions)| trace(*origin, directions)).sum()
    }
}

/// A ball of radius 0.8 with dents, of `around` vertices around.
pub(crate) fn dented_ball(around: usize) -> Vec<[[f32; 3]; 3]> {
    let mut corners = Vec::new();
    patch(around, around / 2, &mut corners, |u, v| {
        // From below upwards, so that triangles face outwards.
        let (theta, phi) = (0.02 + (TAU / 2.0 - 0.04) * (1.0 - v), TAU * u);
        let radius = 0.8 + 0.08 * (7.0 * phi).sin() * (6.0 * theta).sin();
        let ring = radius * theta.sin();
        [ring * phi.cos(), ring * phi.sin(), radius * theta.cos()]
    });
    corners
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = v.iter().map(|c| c * c).sum::<f32>().sqrt();
    v.map(|c| c / length)
}

fn patch(m: usize, n: usize, corners: &mut Vec<[[f32; 3]; 3]>, at: impl Fn(f32, f32) -> [f32; 3]) {
    let at = |i: usize, j: usize| at(i as f32 / m as f32, j as f32 / n as f32);
    for j in 0..n {
        for i in 0..m {
            // Seen from the side that the rays go to.
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            corners.extend([[a, b, c], [a, c, d]]);
        }
    }
}
