//! Test directions: Fibonacci spirals, and the special directions of the sphere.

/// `count` nearly uniform unit vectors on a Fibonacci spiral.
#[must_use]
pub fn fibonacci_sphere(count: usize) -> Vec<[f64; 3]> {
    let golden_ratio = (1.0 + 5.0_f64.sqrt()) / 2.0;
    (0..count)
        .map(|i| {
            let z = 1.0 - (2 * i + 1) as f64 / count as f64;
            let phi = 2.0 * std::f64::consts::PI * (i as f64 / golden_ratio).fract();
            let r = (1.0 - z * z).sqrt();
            [r * phi.cos(), r * phi.sin(), z]
        })
        .collect()
}

/// The directions every property is tested at: the 26 axes, edge and corner directions of the cube (poles
/// included), pairs close to the poles, on both sides of the seam `φ = π` and on it with either sign of zero, and a
/// Fibonacci sphere.
#[must_use]
pub fn directions() -> Vec<[f64; 3]> {
    let mut all = Vec::new();
    for x in -1..=1 {
        for y in -1..=1 {
            for z in -1..=1 {
                if (x, y, z) != (0, 0, 0) {
                    all.push([f64::from(x), f64::from(y), f64::from(z)]);
                }
            }
        }
    }
    for tilt in [1e-12, 1e-6, 1e-3] {
        for phi in [0.1_f64, 2.0, 4.5] {
            for sign in [-1.0, 1.0] {
                all.push([tilt * phi.cos(), tilt * phi.sin(), sign]);
            }
        }
        all.extend([[-1.0, tilt, 0.3], [-1.0, -tilt, 0.3]]);
    }
    all.extend([[-1.0, 0.0, 0.3], [-1.0, -0.0, 0.3], [-0.0, -0.0, -1.0]]);
    all.extend(fibonacci_sphere(200));
    for v in &mut all {
        let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        *v = v.map(|c| c / length);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_leave_no_octant_pole_or_side_of_the_seam_out() {
        let all = directions();
        for v in &all {
            let square: f64 = v.iter().map(|c| c * c).sum();
            assert!((square - 1.0).abs() < 1e-15, "{v:?} has squared length {square}");
        }
        for octant in 0..8 {
            let inside = |v: &&[f64; 3]| (0..3).all(|k| if octant >> k & 1 == 0 { v[k] > 0.0 } else { v[k] < 0.0 });
            let count = all.iter().filter(inside).count();
            assert!(count >= 20, "octant {octant} has {count} directions");
        }
        for pole in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]] {
            assert!(all.contains(&pole), "{pole:?} is missing");
        }
        let seam = |side: f64| all.iter().any(|v| v[0] < 0.0 && v[1] * side > 0.0 && v[1].abs() < 1e-11);
        assert!(seam(1.0) && seam(-1.0), "both sides of the seam");
    }
}
