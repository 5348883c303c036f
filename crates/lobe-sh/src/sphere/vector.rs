//! Arithmetic of vectors `[x, y, z]`, for the crates of Lobe that have no other vectors: on the sphere they are few, and a
//! vector library would be in every interface.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// A vector in space.
pub type Vec3 = [f64; 3];

/// `a · b`.
#[inline]
#[must_use]
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `Σ_i a_i b_i` of vectors of any equal length.
#[inline]
#[must_use]
pub fn dot_slices(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a × b`.
#[inline]
#[must_use]
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a + b`.
#[inline]
#[must_use]
pub fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
#[inline]
#[must_use]
pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `s a`.
#[inline]
#[must_use]
pub fn scale(a: Vec3, s: f64) -> Vec3 {
    a.map(|c| c * s)
}

/// `a + t b`.
#[inline]
#[must_use]
pub fn add_scaled(a: Vec3, b: Vec3, t: f64) -> Vec3 {
    [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]]
}

/// `|a|`.
#[inline]
#[must_use]
pub fn length(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

/// The vector of length 1 along `a`; a zero vector stays zero.
#[inline]
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

// Three choices of tangents, which stay as they are: samples lie in these frames, so that another choice would change the
// digits of what is computed from them.

/// Two unit tangents `t_1, t_2` at the unit vector `s`, for every `s` on the sphere; `t_1, t_2, s` is right-handed, and `t_1`
/// is at right angles to the axis that is farthest from `s`.
#[inline]
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

/// [`tangents`] with `t_1` along the axis that is farthest from `s`: the frame of importance samples and filters of maps.
#[inline]
#[must_use]
pub fn tangents_along_axis(s: Vec3) -> [Vec3; 2] {
    let least = (0..3).min_by(|&i, &j| s[i].abs().total_cmp(&s[j].abs())).unwrap_or(0);
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let t = unit(add_scaled(axis, s, -s[least]));
    [t, cross(s, t)]
}

/// [`tangents`] with `t_1` along z, near the poles along x: the frame of rays and plots.
#[inline]
#[must_use]
pub fn tangents_along_z(s: Vec3) -> [Vec3; 2] {
    let axis = if s[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    let t = normalized(sub(axis, scale(s, dot(axis, s))));
    [t, cross(s, t)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::directions;

    #[test]
    fn frames_are_right_handed_and_orthonormal() {
        for s in directions() {
            for [a, b] in [tangents(s), tangents_along_axis(s), tangents_along_z(s)] {
                let n = cross(a, b);
                for (found, expected) in [(dot(a, a), 1.0), (dot(a, b), 0.0), (dot(a, s), 0.0), (dot(n, s), 1.0)] {
                    assert!((found - expected).abs() < 2e-15, "at {s:?}: {found} against {expected}");
                }
            }
        }
    }
}
