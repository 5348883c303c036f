//! Vectors of three numbers.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

pub(crate) fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

/// The vector of length 1 along `v`, which is not zero.
pub(crate) fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = length(v);
    v.map(|c| c / length)
}

/// Two unit tangents `t_1, t_2` at the unit vector `s`, for every `s` on the sphere; `t_1, t_2, s` is right-handed.
pub(crate) fn tangents(s: [f64; 3]) -> [[f64; 3]; 2] {
    // The axis that is farthest from `s` cannot be parallel to it.
    let [x, y, z] = s.map(f64::abs);
    let axis = if x <= y && x <= z {
        [1.0, 0.0, 0.0]
    } else if y <= z {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let t = unit(cross(axis, s));
    [t, cross(s, t)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::directions;

    #[test]
    fn frames_are_right_handed_and_orthonormal() {
        for s in directions() {
            let [a, b] = tangents(s);
            let n = cross(a, b);
            for (found, expected) in [(dot(a, a), 1.0), (dot(a, b), 0.0), (dot(a, s), 0.0), (dot(n, s), 1.0)] {
                assert!((found - expected).abs() < 1e-15, "at {s:?}: {found} against {expected}");
            }
        }
    }
}
