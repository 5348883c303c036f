//! A frame around a direction.

use lobe_sh::vector::{Vec3, add_scaled, cross, length};

/// Two unit vectors that make a right-handed frame `(u, v, w)` with the unit vector `w`. Importance samples lie about `w` in
/// this frame: another choice of `u` would turn them, and change the digits of every filtered map.
pub(crate) fn frame(w: Vec3) -> (Vec3, Vec3) {
    // The axis least along w, made perpendicular to it: no cancellation.
    let least = (0..3).min_by(|&i, &j| w[i].abs().total_cmp(&w[j].abs())).unwrap_or(0);
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let u = add_scaled(axis, w, -w[least]);
    let u = u.map(|c| c / length(u));
    (u, cross(w, u))
}
