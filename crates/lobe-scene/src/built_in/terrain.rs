//! Terrain of hills and valleys.

use glam::DVec3;

use crate::built_in::shapes::{Shape, scene};
use crate::{Material, Scene};

/// Half the side of the terrain.
const HALF: f64 = 20.0;

/// A terrain: heights between -4 and 4 over a square of side 40 about the origin, in `cells` × `cells` cells.
///
/// ```text
///   h(x, y) = Σ_k  2 · 0.55^k sin( f_k (x cos a_k + y sin a_k) + k )       f_k = 0.21 · 1.7^k,  a_k = 2.4 k,  k = 0..6
/// ```
///
/// divided by 1.1 to stay within its bounds. Its albedo is (0.4, 0.42, 0.25); normals are those of the formula.
///
/// # Panics
/// If `cells` is zero.
#[must_use]
pub fn terrain(cells: usize) -> Scene {
    assert!(cells > 0, "no cells");
    let mut ground = Shape::default();
    ground.surface((cells, cells), |u, v| {
        let (x, y) = (HALF * (2.0 * u - 1.0), HALF * (2.0 * v - 1.0));
        let (height, [dx, dy]) = height(x, y);
        (DVec3::new(x, y, height), DVec3::new(-dx, -dy, 1.0).normalize())
    });
    scene(vec![ground.into_mesh("terrain", 0)], vec![Material::matte("grass", [0.4, 0.42, 0.25])])
}

/// Height and its slopes.
fn height(x: f64, y: f64) -> (f64, [f64; 2]) {
    let (mut height, mut slopes) = (0.0, [0.0; 2]);
    for k in 0..7 {
        let amplitude = 2.0 / 1.1 * 0.55_f64.powi(k);
        let frequency = 0.21 * 1.7_f64.powi(k);
        let (sin_a, cos_a) = (2.4 * f64::from(k)).sin_cos();
        let (sin, cos) = (frequency * (x * cos_a + y * sin_a) + f64::from(k)).sin_cos();
        height += amplitude * sin;
        slopes[0] += amplitude * frequency * cos_a * cos;
        slopes[1] += amplitude * frequency * sin_a * cos;
    }
    (height, slopes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_those_of_the_heights_and_heights_keep_their_bounds() {
        let e = 1e-5;
        for (x, y) in [(0.0, 0.0), (-19.0, 3.3), (7.7, 12.1)] {
            let (_, [dx, dy]) = height(x, y);
            let difference = |a: (f64, f64), b: (f64, f64)| (height(a.0, a.1).0 - height(b.0, b.1).0) / (2.0 * e);
            let (fx, fy) = (difference((x + e, y), (x - e, y)), difference((x, y + e), (x, y - e)));
            assert!((dx - fx).abs() < 1e-8 && (dy - fy).abs() < 1e-8, "{dx}, {dy}, expected {fx}, {fy}");
        }
        let bounds = terrain(64).bounds();
        assert!(bounds.min[2] >= -4.0 && bounds.max[2] <= 4.0, "{bounds:?}");
    }
}
