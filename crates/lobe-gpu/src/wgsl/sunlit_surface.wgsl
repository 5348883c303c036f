// uses: surface, sun_light
// Where suns meet a surface.

struct SunlitPlace {
    p: vec3f,
    // The unit normal of the triangle, on the side that is seen.
    plane: vec3f,
}

fn sunlit_place(s: Surface) -> SunlitPlace {
    let a = vertices[s.corners.x].position.xyz;
    let b = vertices[s.corners.y].position.xyz;
    let c = vertices[s.corners.z].position.xyz;
    let plane = normalize(cross(b - a, c - a)) * select(-1.0, 1.0, s.is_front);
    return SunlitPlace(s.weights.x * a + s.weights.y * b + s.weights.z * c, plane);
}
