//! Arithmetic of vectors `[x, y, z]`, for the crates of Lobe that have no other vectors: on the sphere they are few, and a
//! vector library would be in every interface.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// A vector in space.
pub type Vec3 = [f64; 3];

/// `a · b`.
#[must_use]
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a × b`.
#[must_use]
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a + b`.
#[must_use]
pub fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
#[must_use]
pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `s a`.
#[must_use]
pub fn scale(a: Vec3, s: f64) -> Vec3 {
    a.map(|c| c * s)
}

/// `a + t b`.
#[must_use]
pub fn add_scaled(a: Vec3, b: Vec3, t: f64) -> Vec3 {
    [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]]
}

/// `|a|`.
#[must_use]
pub fn length(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

/// The vector of length 1 along `a`; a zero vector stays zero.
#[must_use]
pub fn normalized(a: Vec3) -> Vec3 {
    let length = length(a);
    if length > 0.0 { scale(a, length.recip()) } else { a }
}

/// The vector of length 1 along `v`, which is not zero. Divides, so that it is within one rounding of exact.
pub(crate) fn unit(v: Vec3) -> Vec3 {
    let length = length(v);
    v.map(|c| c / length)
}

/// Two unit tangents `t_1, t_2` at the unit vector `s`, for every `s` on the sphere; `t_1, t_2, s` is right-handed.
#[must_use]
pub fn tangents(s: Vec3) -> [Vec3; 2] {
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
