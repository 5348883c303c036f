//! Directions spread over the sphere: a Fibonacci spiral, and points at rest in Thomson's problem.

use crate::prelude::*;
use crate::sphere::Dir;
use crate::sphere::vector::{dot, sub, unit};

/// The most steps: the largest set needs some 500.
const STEPS: usize = 5000;

/// The sum of the net forces at which the points are in equilibrium.
const AT_REST: f64 = 1e-9;

/// `count` directions that cover the sphere evenly, on a Fibonacci spiral from +z to -z.
///
/// ```text
///   z_k = 1 - (2k + 1)/count        φ_k = π (3 - √5) k
/// ```
pub fn even_directions(count: usize) -> impl Iterator<Item = Dir> {
    let golden_angle = core::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |k| {
        let z = 1.0 - (2 * k + 1) as f64 / count as f64;
        Dir::from_angles(z.acos(), golden_angle * k as f64)
    })
}

/// The solution of Thomson's problem: `count` points on the sphere that repel each other with the inverse square of
/// their distance, in equilibrium.
///
/// Each point moves along its net force without the part normal to the sphere, times a step that doubles when the
/// energy falls and halves, the move undone, when it rises ([Sloan 2008]; the paper compares the sum of the forces, but
/// the energy alone tells a minimum from a saddle). The start is a spiral, so the result is always the same. The test
/// `the_points_have_the_least_known_energies` compares with the published minima.
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
pub(crate) fn thomson_points(count: usize) -> Vec<[f64; 3]> {
    // Start from a spiral, which lacks the symmetries that would end in a saddle.
    let mut points: Vec<[f64; 3]> = even_directions(count).map(Dir::to_array).collect();
    let mut step = 0.1 / count.max(1) as f64;
    let mut lowest = energy(&points);
    for _ in 0..STEPS {
        let forces = tangential_forces(&points);
        if forces.iter().map(|f| dot(*f, *f).sqrt()).sum::<f64>() < AT_REST {
            break;
        }
        let moved: Vec<[f64; 3]> =
            points.iter().zip(&forces).map(|(p, f)| unit([0, 1, 2].map(|k| p[k] + step * f[k]))).collect();
        let after = energy(&moved);
        if after < lowest {
            (points, lowest) = (moved, after);
            step *= 2.0;
        } else {
            step *= 0.5;
        }
    }
    points
}

/// The sum of the inverse distances of all pairs.
fn energy(points: &[[f64; 3]]) -> f64 {
    let pairs = points.iter().enumerate().flat_map(|(k, a)| points[..k].iter().map(move |b| (a, b)));
    pairs.map(|(a, b)| sub(*a, *b)).map(|d| dot(d, d).sqrt().recip()).sum()
}

fn tangential_forces(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let force = |(i, p): (usize, &[f64; 3])| {
        let mut sum = [0.0; 3];
        for (j, q) in points.iter().enumerate() {
            if j != i {
                let d = sub(*p, *q);
                let scale = dot(d, d).powf(-1.5);
                sum = [0, 1, 2].map(|k| sum[k] + scale * d[k]);
            }
        }
        let along = dot(sum, *p);
        [0, 1, 2].map(|k| sum[k] - along * p[k])
    };
    points.iter().enumerate().map(force).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::Zonal;
    use crate::sphere::vector::cross;

    #[test]
    fn the_points_have_the_least_known_energies() {
        let known = [(3, 1.732050808), (6, 9.985281374), (10, 32.716949460), (15, 80.670244114), (22, 185.287536149)];
        for (count, expected) in known {
            let found = energy(&thomson_points(count));
            assert!((found - expected).abs() < 2e-9, "{count} points: {found} against {expected}");
        }
    }

    #[test]
    fn a_lone_point_stays_and_none_is_none() {
        assert_eq!(thomson_points(1).len(), 1, "one point");
        assert!(thomson_points(0).is_empty(), "no points");
    }

    /// The greatest distance of any direction from the nearest point: at a circle through three points that has none
    /// inside.
    fn covering_radius(points: &[[f64; 3]]) -> f64 {
        let mut least = 1.0_f64;
        for (i, a) in points.iter().enumerate() {
            for (j, b) in points[..i].iter().enumerate() {
                for c in &points[..j] {
                    let normal = unit(cross(sub(*b, *a), sub(*c, *a)));
                    for center in [normal, normal.map(|x| -x)] {
                        let cosine = dot(center, *a);
                        if points.iter().all(|p| dot(center, *p) < cosine + 1e-9) {
                            least = least.min(cosine);
                        }
                    }
                }
            }
        }
        least.acos().to_degrees()
    }

    /// The angle at which an impulse of an order is lowest for the first time, to 0.001 degrees.
    fn first_trough(order: usize) -> f64 {
        let z = Zonal::impulse(order);
        let at = |k: u32| z.eval((1e-3 * f64::from(k)).to_radians().cos());
        1e-3 * f64::from((1..180_000).find(|k| at(k + 1) > at(*k)).unwrap_or(180_000))
    }

    /// From any maximum a start of the paper is so near that an impulse there would slope towards it.
    #[test]
    fn the_points_cover_the_sphere_as_the_orders_need() {
        for (order, count, radius, trough) in [
            (2, 3, 90.0, 180.0),
            (3, 6, 54.736, 101.537),
            (4, 10, 42.436, 74.859),
            (5, 15, 35.282, 59.483),
            (6, 22, 28.443, 49.400),
        ] {
            let found = covering_radius(&thomson_points(count));
            assert!((found - radius).abs() < 1e-3, "{count} points leave {found} degrees, expected {radius}");
            let slope_ends = first_trough(order);
            assert!((slope_ends - trough).abs() < 2e-3, "order {order} has its first trough at {slope_ends} degrees");
            assert!(found < 2.0 / 3.0 * slope_ends, "order {order}: {found} of {slope_ends} degrees");
        }
    }
}
