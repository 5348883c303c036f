//! Arithmetic of vectors in space.

/// A point or a vector.
pub(crate) type Vec3 = [f64; 3];

pub(crate) fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + t b`.
pub(crate) fn add_scaled(a: Vec3, b: Vec3, t: f64) -> Vec3 {
    [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]]
}

pub(crate) fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn length(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

/// Two unit vectors that make a right-handed frame `(u, v, w)` with the unit vector `w`.
pub(crate) fn frame(w: Vec3) -> (Vec3, Vec3) {
    // The axis least along w, made perpendicular to it: no cancellation.
    let least = (0..3).min_by(|&i, &j| w[i].abs().total_cmp(&w[j].abs())).unwrap_or(0);
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let u = add_scaled(axis, w, -w[least]);
    let u = u.map(|c| c / length(u));
    (u, cross(w, u))
}
