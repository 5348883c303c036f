// uses: camera, transfer_texture
// Exit radiance of matte vertices, interpolated, by an index buffer: as `draw_vertices`, for devices whose shaders
// read no buffers. What lights a vertex is summed where it is drawn.

@group(0) @binding(0) var<uniform> camera: Camera;

struct Varying {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(perspective, centroid) radiance: vec3f,
}

@vertex
fn vertex(@builtin(vertex_index) number: u32, @location(0) position: vec3f) -> Varying {
    return Varying(camera_clip(camera, position), sent_back(number));
}

@fragment
fn fragment(in: Varying, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return shown(select(vec3f(0.0), in.radiance, is_front));
}
