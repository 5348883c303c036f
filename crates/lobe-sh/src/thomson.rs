//! Points on the sphere that push each other away: Thomson's problem.

/// Steps after which the points rest: the largest set needs some 500.
const STEPS: usize = 5000;

/// The net force, summed over the points, at which they rest.
const AT_REST: f64 = 1e-9;

/// `count` points on the sphere that repel each other with the inverse square of their distance, at rest.
///
/// Each point moves along its net force without the part normal to the sphere, times a step that doubles when the energy
/// falls and halves, the move undone, when it rises ([Sloan 2008]; the paper watches the sum of the forces, but the energy
/// alone tells a minimum from a saddle). The start is a spiral, so the result is always the same. The test
/// `the_points_have_the_least_known_energies` compares with the published minima.
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
pub(crate) fn thomson_points(count: usize) -> Vec<[f64; 3]> {
    let mut points = spiral(count);
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
    pairs.map(|(a, b)| difference(*a, *b)).map(|d| dot(d, d).sqrt().recip()).sum()
}

fn tangential_forces(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let force = |(i, p): (usize, &[f64; 3])| {
        let mut sum = [0.0; 3];
        for (j, q) in points.iter().enumerate() {
            if j != i {
                let d = difference(*p, *q);
                let scale = dot(d, d).powf(-1.5);
                sum = [0, 1, 2].map(|k| sum[k] + scale * d[k]);
            }
        }
        let along = dot(sum, *p);
        [0, 1, 2].map(|k| sum[k] - along * p[k])
    };
    points.iter().enumerate().map(force).collect()
}

/// Evenly spread to begin with, and without any symmetry that a saddle would need.
fn spiral(count: usize) -> Vec<[f64; 3]> {
    let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let point = |k: usize| {
        let z = 1.0 - (2 * k + 1) as f64 / count as f64;
        let (sin, cos) = (golden_angle * k as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [r * cos, r * sin, z]
    };
    (0..count).map(point).collect()
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|c| c / length)
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
