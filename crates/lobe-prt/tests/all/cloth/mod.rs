//! Transfer in closed form over a surface, for tests without rays.

use lobe_prt::{Channels, Transfer};
use lobe_sh::{Dir, eval_basis};
use lobe_testkit::fibonacci_sphere;

/// Directions of the projection; its error is the same kind of smooth number at every vertex.
const DIRECTIONS: usize = 600;

/// The transfer of `side²` vertices of a wavy cloth under a ball: clamped cosine times visibility, by a sum over
/// directions.
///
/// The ground stops what comes from below, the ball what comes through it; in color both send some light back, red from
/// the ball and green from the ground, and the albedo turns from white to blue along the cloth.
pub(crate) fn cloth(side: usize, order: usize, channels: Channels) -> Transfer {
    let dirs = fibonacci_sphere(DIRECTIONS);
    let basis: Vec<Vec<f64>> = dirs.iter().map(|s| eval_basis(Dir::from_unit(*s), order)).collect();
    let mut coefficients = Vec::new();
    for v in 0..side * side {
        let at = |k: usize| 2.0 * (k as f64 + 0.5) / side as f64 - 1.0;
        let (x, y) = (at(v % side), at(v / side));
        let (z, dx, dy) = (
            0.3 * (3.0 * x).sin() * (2.0 * y).cos(),
            0.9 * (3.0 * x).cos() * (2.0 * y).cos(),
            -0.6 * (3.0 * x).sin() * (2.0 * y).sin(),
        );
        let length = (dx * dx + dy * dy + 1.0).sqrt();
        let normal = [-dx / length, -dy / length, 1.0 / length];
        let to_ball = [0.2 - x, 0.1 - y, 0.9 - z];
        let distance = to_ball.iter().map(|c| c * c).sum::<f64>().sqrt();
        let cone = (1.0 - (0.35 / distance).powi(2)).sqrt() * distance;
        for c in 0..channels.count() {
            let albedo = [1.0 - 0.3 * (x + 1.0), 1.0 - 0.2 * (y + 1.0), 1.0][c];
            let mut sums = vec![0.0; order * order];
            for (s, basis) in dirs.iter().zip(&basis) {
                let dot = |v: [f64; 3]| v[0] * s[0] + v[1] * s[1] + v[2] * s[2];
                let seen = if dot(to_ball) > cone {
                    [0.3, 0.05, 0.05][c]
                } else if s[2] < 0.0 {
                    [0.05, 0.2, 0.05][c]
                } else {
                    1.0
                };
                let seen = if channels == Channels::Gray { f64::from(u8::from(seen == 1.0)) } else { seen };
                let weight = 4.0 / DIRECTIONS as f64 * albedo * seen * dot(normal).max(0.0);
                sums.iter_mut().zip(basis).for_each(|(sum, y)| *sum += weight * y);
            }
            coefficients.extend(sums.into_iter().map(|x| x as f32));
        }
    }
    Transfer::new(order, channels, coefficients).unwrap()
}

/// A result computed with the given number of threads.
pub(crate) fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}
