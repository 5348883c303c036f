//! Tangents at a direction.

use lobe_sh::vector::{Vec3, cross, dot, normalized, scale, sub};

/// Two unit vectors `u`, `v` with `u × v = s`, for a unit vector `s`.
pub(crate) fn tangents(s: Vec3) -> [Vec3; 2] {
    let axis = if s[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    let u = normalized(sub(axis, scale(s, dot(axis, s))));
    [u, cross(s, u)]
}
