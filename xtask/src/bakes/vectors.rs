//! Vectors of three numbers.

/// A point, a direction or a color.
pub(super) type Vector = [f64; 3];

pub(super) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(super) fn sub(a: Vector, b: Vector) -> Vector {
    add(a, scaled(b, -1.0))
}

pub(super) fn scaled(a: Vector, by: f64) -> Vector {
    a.map(|c| c * by)
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn normalized(a: Vector) -> Vector {
    scaled(a, 1.0 / dot(a, a).sqrt())
}

/// Two directions that are right-handed with a unit vector.
pub(super) fn across(axis: Vector) -> (Vector, Vector) {
    let other = if axis[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let u = normalized(cross(axis, other));
    (u, cross(axis, u))
}

/// A vector turned about an axis through the origin, counterclockwise seen from its tip, by Rodrigues' formula.
pub(super) fn turned(v: Vector, axis: Vector, degrees: f64) -> Vector {
    let (k, (sin, cos)) = (normalized(axis), degrees.to_radians().sin_cos());
    add(add(scaled(v, cos), scaled(cross(k, v), sin)), scaled(k, dot(k, v) * (1.0 - cos)))
}
