// uses: camera
// Exit radiance of vertices, interpolated, by an index buffer: as `shade_vertices`, where no surface has holes, at a fraction of the
// work. Black from behind, where no transfer is known.

@group(0) @binding(0) var<uniform> camera: Camera;

struct Varying {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(perspective, centroid) radiance: vec3f,
}

@vertex
fn vertex(@location(0) position: vec3f, @location(1) radiance: vec3f) -> Varying {
    return Varying(camera_clip(camera, position), radiance);
}

@fragment
fn fragment(in: Varying, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return shown(select(vec3f(0.0), in.radiance, is_front));
}
