// uses: surface, sun_light
// What a surface sends back of the suns of a light: albedo / pi * E.

fn sunlight(s: Surface) -> vec3f {
    let a = vertices[s.corners.x].position.xyz;
    let b = vertices[s.corners.y].position.xyz;
    let c = vertices[s.corners.z].position.xyz;
    let plane = normalize(cross(b - a, c - a)) * select(-1.0, 1.0, s.is_front);
    let p = s.weights.x * a + s.weights.y * b + s.weights.z * c;
    return s.albedo.rgb * suns_irradiance(p, plane, s.normal) / 3.14159265358979;
}
