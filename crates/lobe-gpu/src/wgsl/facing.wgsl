// The normals of a surface that is drawn without its corners, on the side that is seen.

struct Facing {
    // To shade with, and that of the triangle.
    normal: vec3f,
    plane: vec3f,
}

// By the derivatives of the place and the normal between vertices.
fn facing_of(at: vec3f, between: vec3f, is_front: bool) -> Facing {
    let across = cross(dpdx(at), dpdy(at));
    let normal = select(-1.0, 1.0, is_front) * normalize(between);
    let length_of = length(across);
    let flat = select(normal, across / length_of, length_of > 0.0);
    return Facing(normal, select(-flat, flat, dot(flat, normal) >= 0.0));
}
