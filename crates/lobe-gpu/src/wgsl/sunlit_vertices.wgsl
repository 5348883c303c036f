// uses: camera, sun_light
// The fragment of vertices under suns: their exit radiance, and that of the suns by the normal and the albedo between
// them. Without transfer from behind, where none is known, and black there unless surfaces are double-sided.

@group(0) @binding(0) var<uniform> camera: Camera;

struct Varying {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(perspective, centroid) radiance: vec3f,
    @location(1) at: vec3f,
    @location(2) @interpolate(perspective, centroid) normal: vec3f,
    @location(3) @interpolate(perspective, centroid) albedo: vec3f,
}

@fragment
fn fragment(in: Varying, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let across = cross(dpdx(in.at), dpdy(in.at));
    if !is_front && DOUBLE_SIDED == 0u {
        return shown(vec3f(0.0));
    }
    let side = select(-1.0, 1.0, is_front);
    let normal = side * normalize(in.normal);
    let length_of = length(across);
    let flat = select(normal, across / length_of, length_of > 0.0);
    let plane = select(-flat, flat, dot(flat, normal) >= 0.0);
    let radiance = select(vec3f(0.0), in.radiance, is_front);
    return shown(radiance + in.albedo * suns_irradiance(in.at, plane, normal) / 3.14159265358979);
}
