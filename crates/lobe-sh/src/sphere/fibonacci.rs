//! Directions spread evenly over the sphere.

use crate::Dir;

/// `count` directions that cover the sphere evenly, on a Fibonacci spiral from +z to -z.
///
/// ```text
///   z_k = 1 - (2k + 1)/count        φ_k = π (3 - √5) k
/// ```
pub fn even_directions(count: usize) -> impl Iterator<Item = Dir> {
    let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |k| {
        let z = 1.0 - (2 * k + 1) as f64 / count as f64;
        Dir::from_angles(z.acos(), golden_angle * k as f64)
    })
}
