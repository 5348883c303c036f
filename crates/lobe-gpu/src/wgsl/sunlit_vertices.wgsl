// uses: camera, facing, sun_light
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
    // Derivatives are those of all fragments.
    let facing = facing_of(in.at, in.normal, is_front);
    if !is_front && DOUBLE_SIDED == 0u {
        return shown(vec3f(0.0));
    }
    let radiance = select(vec3f(0.0), in.radiance, is_front);
    return shown(radiance + in.albedo * suns_irradiance(in.at, facing.plane, facing.normal) / 3.14159265358979);
}
