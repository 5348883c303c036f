// uses: elementary
// The octahedral mapping, as `lobe_env::octahedral`: the sphere on an octahedron, its lower half folded out to a
// square. After Praun and Hoppe 2003; Engelhardt and Dachsbacher 2008.

// The point of the octahedral map, in the unit square, of the direction s of any length except 0.
// The middle is +z, the corners are -z.
fn octahedral_uv_from_dir(s: vec3f) -> vec2f {
    let p = s.xy / (abs(s.x) + abs(s.y) + abs(s.z));
    let folded = (1.0 - abs(p.yx)) * vec2f(side_of(p.x), side_of(p.y));
    return 0.5 + 0.5 * select(p, folded, s.z < 0.0);
}

// The unit vector of a point of the octahedral map in the unit square, to which other points are clamped.
fn octahedral_dir_from_uv(uv: vec2f) -> vec3f {
    let p = clamp(2.0 * uv - 1.0, vec2f(-1.0), vec2f(1.0));
    let folded = (1.0 - abs(p.yx)) * vec2f(side_of(p.x), side_of(p.y));
    let z = 1.0 - abs(p.x) - abs(p.y);
    return normalize(vec3f(select(p, folded, z < 0.0), z));
}
